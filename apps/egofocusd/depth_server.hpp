// Hands the depth memory to those who connect, and wakes them. include/egofocus/depth_reader.h is their side.
#pragma once

#include <poll.h>

#include <cstddef>
#include <vector>

#include "daemon_config.hpp"
#include "depth_memory.hpp"
#include "descriptor.hpp"
#include "unix_socket.hpp"

namespace egofocus::daemon {

/// No call waits: a reader that does not take its wake-ups loses them, one that is gone is forgotten. Thread:
/// the service's.
class DepthServer {
 public:
  static constexpr std::size_t kMostReaders = 32;

  /// Throws Error: kBusy when another daemon has the socket, kFile.
  explicit DepthServer(const SocketConfig& config);

  /// From now on those who connect get this one, which outlives its use here. Who has another one is
  /// disconnected, and comes again.
  void show(const DepthMemory* memory);

  /// New readers in, dead ones out.
  void serve();
  /// To each reader: there is a new frame.
  void wake_readers();

  void add_to(std::vector<pollfd>& watched) const;
  [[nodiscard]] std::size_t readers() const noexcept { return readers_.size(); }

 private:
  ListeningSocket socket_;
  const DepthMemory* memory_ = nullptr;
  std::vector<Descriptor> readers_;
};

}  // namespace egofocus::daemon
