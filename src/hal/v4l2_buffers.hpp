// The mapped buffers of a V4L2 capture queue.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/status.hpp"
#include "hal/v4l2_file.hpp"

namespace egofocus {

/// A buffer that the driver filled. Nothing in it was trusted: `bytes` lies within the mapping.
struct V4l2Filled {
  std::uint32_t index = 0;
  std::uint32_t sequence = 0;
  std::span<const std::byte> bytes;
  bool has_error = false;  ///< V4L2_BUF_FLAG_ERROR
  bool is_wrong = false;   ///< more bytes used than the buffer has; `bytes` is empty
  bool has_stamp = false;  ///< of CLOCK_MONOTONIC, at the end of the frame
  std::int64_t stamp_us = 0;
};

/// Thread: one. RT: take and give_back yes.
class V4l2Buffers {
 public:
  explicit V4l2Buffers(V4l2File& file) noexcept : file_(&file) {}
  ~V4l2Buffers() { stop(); }
  V4l2Buffers(const V4l2Buffers&) = delete;
  V4l2Buffers& operator=(const V4l2Buffers&) = delete;

  /// Asks for `count` buffers, maps and queues all that the driver gives, and starts the stream. kDeviceBusy:
  /// another process streams. kDeviceLost, kIo. On failure nothing stays mapped.
  Status start(bool is_multiplanar, std::uint32_t count) noexcept;
  /// Stops the stream and unmaps; harmless when not started.
  void stop() noexcept;

  /// The next filled buffer: 0, -EAGAIN when there is none, or another -errno.
  int take(V4l2Filled& filled) noexcept;
  /// 0 or -errno. Precondition: taken, not given back yet.
  int give_back(std::uint32_t index) noexcept;

  [[nodiscard]] std::size_t count() const noexcept { return count_; }

 private:
  static constexpr std::size_t kMost = 32;  // VIDEO_MAX_FRAME

  struct Mapping {
    const std::byte* memory = nullptr;
    std::size_t bytes = 0;
  };

  Status prepare(std::uint32_t count) noexcept;
  Status map(std::uint32_t index) noexcept;

  V4l2File* file_;
  std::uint32_t type_ = 0;
  bool is_multiplanar_ = false;
  bool is_requested_ = false;
  std::array<Mapping, kMost> mappings_;
  std::size_t count_ = 0;
};

}  // namespace egofocus
