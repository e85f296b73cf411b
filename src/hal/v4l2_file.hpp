// One opened device node, closed by RAII.
#pragma once

#include <cerrno>

#include "hal/v4l2_io.hpp"

namespace egofocus {

/// Functions return what V4l2Io does; a call that a signal interrupted is made again, but never without end.
/// Thread: one. RT: no.
class V4l2File {
 public:
  explicit V4l2File(const V4l2Io& io) noexcept : io_(&io) {}
  ~V4l2File() { close(); }
  V4l2File(const V4l2File&) = delete;
  V4l2File& operator=(const V4l2File&) = delete;

  /// 0 or -errno.
  int open(const char* path) noexcept {
    close();
    fd_ = io_->open(io_->self, path);
    return fd_ < 0 ? fd_ : 0;
  }
  void close() noexcept {
    if (is_open()) io_->close(io_->self, fd_);
    fd_ = -1;
  }
  [[nodiscard]] bool is_open() const noexcept { return fd_ >= 0; }

  template <typename Argument>
  int ioctl(unsigned long request, Argument& argument) const noexcept {
    constexpr int kMostTries = 8;
    int code = -EINTR;
    for (int i = 0; i < kMostTries && code == -EINTR; ++i) {
      code = io_->ioctl(io_->self, fd_, request, &argument);
    }
    return code;
  }
  int map(std::size_t bytes, std::int64_t offset, const std::byte*& memory) const noexcept {
    return io_->map(io_->self, fd_, bytes, offset, memory);
  }
  void unmap(const std::byte* memory, std::size_t bytes) const noexcept {
    io_->unmap(io_->self, memory, bytes);
  }
  int wait(std::int64_t timeout_us) const noexcept { return io_->wait(io_->self, fd_, timeout_us); }
  int number(std::uint32_t& major, std::uint32_t& minor) const noexcept {
    return io_->number_of(io_->self, fd_, major, minor);
  }
  [[nodiscard]] const V4l2Io& io() const noexcept { return *io_; }

 private:
  const V4l2Io* io_;
  int fd_ = -1;
};

}  // namespace egofocus
