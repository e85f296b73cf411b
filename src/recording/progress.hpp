// A progress bar on stderr, drawn only when that is a terminal.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <string>

namespace egofocus::recording {

class Progress {
 public:
  explicit Progress(std::string label) : label_(std::move(label)), shown_(isatty(STDERR_FILENO) == 1) {}
  ~Progress() {
    if (drawn_permille_ >= 0) std::fputs("\r\033[K", stderr);
  }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Draws when the bar has grown by a thousandth.
  void show(std::size_t done, std::size_t all) {
    if (!shown_ || all == 0) return;
    const int permille = static_cast<int>(static_cast<double>(done) / static_cast<double>(all) * 1000.0);
    if (permille == drawn_permille_) return;
    drawn_permille_ = permille;
    constexpr int kWidth = 40;
    const int filled = permille * kWidth / 1000;
    std::fprintf(stderr, "\r%s [%s%s] %3d %%", label_.c_str(),
                 std::string(static_cast<std::size_t>(filled), '#').c_str(),
                 std::string(static_cast<std::size_t>(kWidth - filled), '.').c_str(), permille / 10);
    std::fflush(stderr);
  }

 private:
  std::string label_;
  bool shown_;
  int drawn_permille_ = -1;
};

}  // namespace egofocus::recording
