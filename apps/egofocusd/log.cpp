#include "log.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <mutex>
#include <string>

namespace egofocus::daemon {
namespace {

constexpr double kMostLines = 20;
constexpr double kLinesPerSecond = 2;
constexpr std::size_t kLongestLine = 1000;

std::mutex guard;
double credit = kMostLines;
std::chrono::steady_clock::time_point credited = std::chrono::steady_clock::now();
unsigned long long left_out = 0;
unsigned long long told_left_out = 0;

bool may_write() {
  const auto now = std::chrono::steady_clock::now();
  credit =
      std::min(kMostLines, credit + std::chrono::duration<double>(now - credited).count() * kLinesPerSecond);
  credited = now;
  if (credit < 1) return false;
  credit -= 1;
  return true;
}

// A pipe or a socket that polls writable takes a line of this length without waiting.
bool write_line(const std::string& line) {
  pollfd out{STDERR_FILENO, POLLOUT, 0};
  if (::poll(&out, 1, 0) != 1 || (out.revents & POLLOUT) == 0) return false;
  return ::write(STDERR_FILENO, line.data(), line.size()) == static_cast<ssize_t>(line.size());
}

}  // namespace

void log(Priority priority, std::string_view text) {
  static const bool to_journal = std::getenv("JOURNAL_STREAM") != nullptr;
  const std::lock_guard lock(guard);
  if (!may_write()) {
    ++left_out;
    return;
  }
  std::string line = to_journal ? "<" + std::to_string(static_cast<int>(priority)) + ">" : "egofocusd: ";
  line += text.substr(0, kLongestLine);
  if (left_out > told_left_out)
    line += " (" + std::to_string(left_out - told_left_out) + " lines before this one were left out)";
  std::replace(line.begin(), line.end(), '\n', ' ');
  if (write_line(line + "\n")) {
    told_left_out = left_out;
  } else {
    ++left_out;
  }
}

unsigned long long lines_left_out() {
  const std::lock_guard lock(guard);
  return left_out;
}

}  // namespace egofocus::daemon
