#include "unix_socket.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "recording/error.hpp"

namespace egofocus::daemon {
namespace {

using recording::Error;
using recording::ExitCode;

constexpr int kWaiting = 16;
constexpr int kLockTurns = 100;
constexpr useconds_t kLockTurn_us = 20'000;

sockaddr_un address_of(const std::filesystem::path& path) {
  sockaddr_un address{};
  const std::string name = path.string();
  if (name.size() >= sizeof address.sun_path) {
    throw Error(
        ExitCode::kConfiguration, name,
        "is too long for a socket: " + std::to_string(sizeof address.sun_path - 1) + " characters at most.");
  }
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, name.data(), name.size());
  return address;
}

int try_connect(int socket, const sockaddr_un& address) {
  return ::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? 0 : errno;
}

[[noreturn]] void refuse(const std::filesystem::path& path, const char* what) {
  throw Error(ExitCode::kFile, path.string(),
              std::string(what) + " (" + std::strerror(errno) + "). Check the folder and its permissions.");
}

}  // namespace

ListeningSocket::ListeningSocket(const std::filesystem::path& path, int type, bool group) : path_(path) {
  const sockaddr_un address = address_of(path);
  // Looking, removing and binding must be one step: the folder is locked meanwhile.
  const std::filesystem::path folder = path.parent_path();
  const Descriptor lock(::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!lock.is_open()) refuse(path, "cannot be made in its folder");
  for (int turn = 0; ::flock(lock.number(), LOCK_EX | LOCK_NB) != 0; ++turn) {
    if (turn == kLockTurns) refuse(path, "cannot be made: its folder is locked");
    ::usleep(kLockTurn_us);
  }
  const Descriptor probe(::socket(AF_UNIX, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int answer = try_connect(probe.number(), address);
  if (answer == 0 || answer == EAGAIN) {
    throw Error(
        ExitCode::kBusy, path.string(),
        "another egofocusd runs with this socket. Stop it first, or give this one sockets of its own.");
  }
  struct stat there {};
  if (::lstat(path.c_str(), &there) == 0) {
    if (!S_ISSOCK(there.st_mode))
      throw Error(ExitCode::kFile, path.string(), "is there already and is no socket. Choose another name.");
    ::unlink(path.c_str());
  }
  socket_ = Descriptor(::socket(AF_UNIX, type | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const mode_t before = ::umask(group ? 0117 : 0177);
  const int bound = ::bind(socket_.number(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int reason = errno;
  ::umask(before);
  errno = reason;
  if (bound != 0 || ::listen(socket_.number(), kWaiting) != 0) refuse(path, "cannot be listened on");
}

ListeningSocket::~ListeningSocket() {
  if (socket_.is_open()) ::unlink(path_.c_str());
}

Descriptor ListeningSocket::accept() const noexcept {
  return Descriptor(::accept4(socket_.number(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC));
}

Descriptor connect_to(const std::filesystem::path& path, int type, timeval patience) {
  const sockaddr_un address = address_of(path);
  Descriptor socket(::socket(AF_UNIX, type | SOCK_CLOEXEC, 0));
  for (const int direction : {SO_SNDTIMEO, SO_RCVTIMEO})
    ::setsockopt(socket.number(), SOL_SOCKET, direction, &patience, sizeof patience);
  errno = try_connect(socket.number(), address);
  if (errno != 0) {
    throw Error(ExitCode::kFile, path.string(),
                std::string("no egofocusd answers there (") + std::strerror(errno) +
                    "). Does it run, and with this configuration? Are you in its group?");
  }
  return socket;
}

bool is_served(const std::filesystem::path& path) {
  const Descriptor probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int answer = try_connect(probe.number(), address_of(path));
  return answer == 0 || answer == EAGAIN;
}

}  // namespace egofocus::daemon
