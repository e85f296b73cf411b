// The clock of one live source: device times onto the host's, or as they are, and how far its samples are
// complete.
#pragma once

#include <cstdint>

#include "hal/clock_map.hpp"

namespace egofocus {

/// Thread: one. RT: yes.
class SourceClock {
 public:
  /// Another device: `is_raw` takes its times as they are.
  void restart(bool is_raw) noexcept {
    is_raw_ = is_raw;
    restart();
  }
  /// One whose time was reset: nothing can be mapped before the next pair.
  void restart() noexcept {
    map_.reset();
    is_mapped_ = is_raw_;
  }

  /// All of the device's samples up to `device_us` have been taken; the host had the last of them at
  /// `host_us`.
  void observe(std::int64_t device_us, std::int64_t host_us) noexcept {
    map_.observe(device_us, host_us);
    is_mapped_ = true;
    const std::int64_t newest_us = to_host_us(device_us) - 1;  // its microsecond may go on
    if (newest_us > watermark_us_) watermark_us_ = newest_us;
  }

  [[nodiscard]] bool is_mapped() const noexcept { return is_mapped_; }
  /// Precondition: is_mapped().
  [[nodiscard]] std::int64_t to_host_us(std::int64_t device_us) const noexcept {
    return is_raw_ ? device_us : map_.to_host_us(device_us);
  }
  /// Every sample up to here was taken; never goes back; INT64_MIN before the first pair.
  [[nodiscard]] std::int64_t watermark_us() const noexcept { return watermark_us_; }
  [[nodiscard]] const ClockMap& map() const noexcept { return map_; }

 private:
  ClockMap map_;
  bool is_raw_ = false;
  bool is_mapped_ = false;
  std::int64_t watermark_us_ = INT64_MIN;
};

}  // namespace egofocus
