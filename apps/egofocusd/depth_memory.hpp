// Depth frames in memory that other processes may map: one writer that never waits, any number of readers.
// include/egofocus/depth_reader.h is the layout, the readers' side, and the rules between both.
#pragma once

#include <cstddef>
#include <cstdint>

#include "descriptor.hpp"
#include "egofocus/types.hpp"

namespace egofocus::daemon {

class DepthMemory {
 public:
  /// A sealed memory file for frames on this grid. `slots` is a power of two, 2..64. Throws Error (kInternal)
  /// when the system has no memory, or a kernel before 5.1.
  DepthMemory(const Intrinsics& grid, std::uint32_t slots);
  ~DepthMemory();
  DepthMemory(const DepthMemory&) = delete;
  DepthMemory& operator=(const DepthMemory&) = delete;

  /// Can it go on with frames on this grid?
  [[nodiscard]] bool fits(const Intrinsics& grid, std::uint32_t slots) const noexcept {
    return grid.width_px == width_px_ && grid.height_px == height_px_ && slots == slots_;
  }

  /// The frame becomes the newest. Thread: the tick's. RT: yes, O(pixels), no system call.
  void publish(const DepthFrame& frame) noexcept;

  /// To hand out: who gets it can map it for reading alone.
  [[nodiscard]] int descriptor() const noexcept { return file_.number(); }
  [[nodiscard]] const std::byte* memory() const noexcept { return memory_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  [[nodiscard]] std::uint32_t* word(std::size_t at) noexcept {
    return reinterpret_cast<std::uint32_t*>(memory_ + at);
  }
  void copy(std::size_t at, const void* from, std::size_t bytes) noexcept;

  std::int32_t width_px_;
  std::int32_t height_px_;
  std::uint32_t slots_;
  std::size_t slot_bytes_ = 0;
  std::size_t inverse_depth_at_ = 0;
  std::size_t confidence_at_ = 0;
  std::size_t bytes_ = 0;
  std::byte* memory_ = nullptr;
  Descriptor file_;
  std::uint32_t number_ = 0;  // of the newest frame
};

}  // namespace egofocus::daemon
