#include "control_server.hpp"

#include <sys/socket.h>
#include <sys/time.h>

#include <algorithm>
#include <cerrno>

#include "recording/error.hpp"

namespace egofocus::daemon {
namespace {

constexpr std::chrono::seconds kPatience(2);
constexpr timeval kAnswerTime{5, 0};

}  // namespace

ControlServer::ControlServer(const SocketConfig& config)
    : socket_(config.socket, SOCK_STREAM, config.group) {}

bool ControlServer::is_done(Client& client, const Answer& answer) {
  char bytes[kLongestLine + 1];
  const ssize_t got = ::recv(client.socket.number(), bytes, sizeof bytes, MSG_DONTWAIT);
  if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return true;
  if (got > 0) client.said.append(bytes, static_cast<std::size_t>(got));
  const std::size_t end = client.said.find('\n');
  if (end == std::string::npos)
    return client.said.size() > kLongestLine || std::chrono::steady_clock::now() > client.until;
  const std::string line =
      answer(std::string_view(client.said).substr(0, std::min(end, kLongestLine))) + "\n";
  static_cast<void>(::send(client.socket.number(), line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
  return true;
}

void ControlServer::serve(const Answer& answer) {
  while (clients_.size() < kMostClients) {
    Descriptor socket = socket_.accept();
    if (!socket.is_open()) break;
    clients_.push_back({std::move(socket), "", std::chrono::steady_clock::now() + kPatience});
  }
  std::erase_if(clients_, [&](Client& client) { return is_done(client, answer); });
}

void ControlServer::add_to(std::vector<pollfd>& watched) const {
  if (clients_.size() < kMostClients) watched.push_back({socket_.number(), POLLIN, 0});
  for (const Client& client : clients_) watched.push_back({client.socket.number(), POLLIN, 0});
}

std::string ask(const std::filesystem::path& path, const std::string& request) {
  const Descriptor socket = connect_to(path, SOCK_STREAM, kAnswerTime);
  const std::string line = request + "\n";
  std::string answer;
  if (::send(socket.number(), line.data(), line.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(line.size())) {
    char bytes[4096];
    for (ssize_t got = 1; got > 0;) {
      got = ::recv(socket.number(), bytes, sizeof bytes, 0);
      if (got > 0) answer.append(bytes, static_cast<std::size_t>(got));
    }
  }
  if (answer.empty() || answer.back() != '\n')
    throw recording::Error(recording::ExitCode::kFile, path.string(),
                           "gave no whole answer. Is the daemon overloaded?");
  answer.pop_back();
  return answer;
}

}  // namespace egofocus::daemon
