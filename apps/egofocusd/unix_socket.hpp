// Unix sockets with a name in the file system.
#pragma once

#include <sys/time.h>

#include <filesystem>

#include "descriptor.hpp"

namespace egofocus::daemon {

/// A listening socket; its file is removed with it. `type` is SOCK_STREAM or SOCK_SEQPACKET, non-blocking.
/// The file belongs to the owner alone (0600), or to the group as well (0660). What a killed daemon left
/// there is replaced; a socket that someone answers on is not: throws Error (kBusy). Throws Error (kFile)
/// when the folder is missing or not ours to write.
class ListeningSocket {
 public:
  ListeningSocket(const std::filesystem::path& path, int type, bool group);
  ~ListeningSocket();
  ListeningSocket(const ListeningSocket&) = delete;
  ListeningSocket& operator=(const ListeningSocket&) = delete;

  /// The next one who connected, non-blocking; closed when there is none.
  [[nodiscard]] Descriptor accept() const noexcept;
  [[nodiscard]] int number() const noexcept { return socket_.number(); }

 private:
  std::filesystem::path path_;
  Descriptor socket_;
};

/// No call on it, nor the connection itself, waits longer than `patience`. Throws Error: kFile when nobody
/// listens there, or it is not permitted.
[[nodiscard]] Descriptor connect_to(const std::filesystem::path& path, int type, timeval patience);

/// Somebody answers on the stream socket of that name.
[[nodiscard]] bool is_served(const std::filesystem::path& path);

}  // namespace egofocus::daemon
