// Questions and commands over a Unix socket: a line in, a line out, one per connection.
#pragma once

#include <poll.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "daemon_config.hpp"
#include "descriptor.hpp"
#include "unix_socket.hpp"

namespace egofocus::daemon {

/// No call waits. At most 8 at a time, and 2 s each to say their line; who does not take the answer at once
/// does not get it. Thread: the service's.
class ControlServer {
 public:
  static constexpr std::size_t kMostClients = 8;
  static constexpr std::size_t kLongestLine = 200;
  using Answer = std::function<std::string(std::string_view request)>;

  /// Throws Error: kBusy when another daemon has the socket, kFile.
  explicit ControlServer(const SocketConfig& config);

  void serve(const Answer& answer);
  void add_to(std::vector<pollfd>& watched) const;

 private:
  struct Client {
    Descriptor socket;
    std::string said;
    std::chrono::steady_clock::time_point until;
  };
  static bool is_done(Client& client, const Answer& answer);

  ListeningSocket socket_;
  std::vector<Client> clients_;
};

/// The client's side: one line, and the answer without its end. Throws Error (kFile) when no daemon answers.
[[nodiscard]] std::string ask(const std::filesystem::path& socket, const std::string& request);

}  // namespace egofocus::daemon
