#include "depth_memory.hpp"

#include <fcntl.h>
#include <linux/memfd.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <string>

#include "egofocus/depth_reader.h"
#include "recording/error.hpp"

#ifndef F_SEAL_FUTURE_WRITE
#define F_SEAL_FUTURE_WRITE 0x0010  // linux/fcntl.h of 5.1
#endif

namespace egofocus::daemon {
namespace {

static_assert(sizeof(egofocus_depth_header) == 128);
static_assert(sizeof(egofocus_depth_info) == 192);

constexpr std::size_t whole_lines(std::size_t bytes) noexcept {
  return (bytes + 63) / 64 * 64;
}

[[noreturn]] void refuse(const char* what) {
  throw recording::Error(
      recording::ExitCode::kInternal, "shared memory for depth",
      std::string(what) + " (" + std::strerror(errno) + "). Linux 5.1 or newer is needed.");
}

egofocus_depth_info info_of(const DepthFrame& frame) noexcept {
  egofocus_depth_info info{};
  info.t_us = frame.t_us;
  info.age_us = frame.age_us;
  info.latency_us = frame.latency_us;
  info.window_begin_us = frame.window_begin_us;
  info.sequence = frame.sequence;
  info.votes = frame.votes;
  info.inverse_depth_scale_per_m = frame.inverse_depth_scale_per_m;
  info.parallax_px = frame.parallax_px;
  for (int i = 0; i < 3; ++i) {
    info.velocity_m_s[i] = frame.velocity_m_s[i];
    info.angular_rate_rad_s[i] = frame.angular_rate_rad_s[i];
  }
  info.velocity_sigma_m_s = frame.velocity_sigma_m_s;
  info.fx_px = frame.grid.fx_px;
  info.fy_px = frame.grid.fy_px;
  info.cx_px = frame.grid.cx_px;
  info.cy_px = frame.grid.cy_px;
  info.flags = frame.flags;
  info.events = frame.events;
  info.hypotheses = frame.hypotheses;
  info.width_px = static_cast<std::uint32_t>(frame.grid.width_px);
  info.height_px = static_cast<std::uint32_t>(frame.grid.height_px);
  return info;
}

}  // namespace

DepthMemory::DepthMemory(const Intrinsics& grid, std::uint32_t slots)
    : width_px_(grid.width_px), height_px_(grid.height_px), slots_(slots) {
  const auto pixels = static_cast<std::size_t>(width_px_) * static_cast<std::size_t>(height_px_);
  inverse_depth_at_ = whole_lines(EGOFOCUS_DEPTH_INFO_AT + sizeof(egofocus_depth_info));
  confidence_at_ = whole_lines(inverse_depth_at_ + 2 * pixels);
  slot_bytes_ = whole_lines(confidence_at_ + pixels);
  bytes_ = sizeof(egofocus_depth_header) + slots_ * slot_bytes_;

  file_ = Descriptor(::memfd_create("egofocus-depth", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  if (!file_.is_open()) refuse("cannot be made");
  // fallocate: a lack of memory shows now, not as a fault within a tick.
  const int lack = ::posix_fallocate(file_.number(), 0, static_cast<off_t>(bytes_));
  if (lack != 0) {
    errno = lack;
    refuse("cannot be had");
  }
  void* memory =
      ::mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file_.number(), 0);
  if (memory == MAP_FAILED) refuse("cannot be mapped");
  memory_ = static_cast<std::byte*>(memory);
  // From here on only this mapping can be written through.
  if (::fcntl(file_.number(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) !=
      0) {
    ::munmap(memory_, bytes_);
    refuse("cannot be sealed");
  }

  egofocus_depth_header header{};
  std::memcpy(header.magic, EGOFOCUS_DEPTH_MAGIC, sizeof header.magic);
  header.layout = EGOFOCUS_DEPTH_LAYOUT;
  header.header_bytes = sizeof header;
  header.slots = slots_;
  header.slot_bytes = static_cast<std::uint32_t>(slot_bytes_);
  header.width_px = static_cast<std::uint32_t>(width_px_);
  header.height_px = static_cast<std::uint32_t>(height_px_);
  header.inverse_depth_at = static_cast<std::uint32_t>(inverse_depth_at_);
  header.confidence_at = static_cast<std::uint32_t>(confidence_at_);
  std::memcpy(memory_, &header, sizeof header);
}

DepthMemory::~DepthMemory() {
  ::munmap(memory_, bytes_);
}

void DepthMemory::copy(std::size_t at, const void* from, std::size_t bytes) noexcept {
  for (std::size_t done = 0; done < bytes; done += 4) {
    std::uint32_t value = 0;
    std::memcpy(&value, static_cast<const std::byte*>(from) + done, bytes - done < 4 ? bytes - done : 4);
    __atomic_store_n(word(at + done), value, __ATOMIC_RELAXED);
  }
}

// A sequence lock per slot, as in core/snapshot.hpp, whose proof holds here. The slot that is written is the
// oldest; the newest whole frame lies in another one, so a writer that dies in here leaves it readable.
void DepthMemory::publish(const DepthFrame& frame) noexcept {
  const std::uint32_t number = number_ + 1;
  const std::size_t slot = sizeof(egofocus_depth_header) + (number % slots_) * slot_bytes_;
  const egofocus_depth_info info = info_of(frame);
  __atomic_store_n(word(slot), 2 * number - 1, __ATOMIC_RELAXED);
  __atomic_thread_fence(__ATOMIC_RELEASE);
  copy(slot + EGOFOCUS_DEPTH_INFO_AT, &info, sizeof info);
  copy(slot + inverse_depth_at_, frame.inverse_depth.data(), frame.inverse_depth.size_bytes());
  copy(slot + confidence_at_, frame.confidence.data(), frame.confidence.size_bytes());
  __atomic_store_n(word(slot), 2 * number, __ATOMIC_RELEASE);
  __atomic_store_n(word(offsetof(egofocus_depth_header, newest)), number, __ATOMIC_RELEASE);
  number_ = number;
}

}  // namespace egofocus::daemon
