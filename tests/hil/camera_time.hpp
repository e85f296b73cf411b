// The clock of an emulated camera, and how far it has come with sending.
#pragma once

#include <time.h>

#include <algorithm>
#include <atomic>
#include <cstdint>

namespace egofocus::hil {

inline std::int64_t host_us() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000 + now.tv_nsec / 1000;
}

/// A camera's time is CLOCK_MONOTONIC since its pixels were switched on, so that a feed begins with its first
/// event however long the start takes. Thread: begin, end and send: the camera's; the rest any.
class CameraTime {
 public:
  void begin() {
    sent_us_ = 0;
    begun_us_ = host_us();
    ++starts_;
  }
  void end() { begun_us_ = 0; }
  void send(std::int64_t until_us) { sent_us_ = until_us; }
  /// Time stands still there until the limit is moved: for a listener who cannot say that he is busy.
  void limit(std::int64_t t_us) { limit_us_ = t_us; }

  [[nodiscard]] bool runs() const { return begun_us_ != 0; }
  [[nodiscard]] std::int64_t now_us() const {
    return std::min<std::int64_t>(host_us() - begun_us_, limit_us_);
  }
  /// All up to here has been sent; lags behind while nobody asks for it.
  [[nodiscard]] std::int64_t sent_us() const { return sent_us_; }
  [[nodiscard]] std::uint64_t starts() const { return starts_; }

 private:
  std::atomic<std::int64_t> begun_us_{0};
  std::atomic<std::int64_t> sent_us_{0};
  std::atomic<std::int64_t> limit_us_{INT64_MAX};
  std::atomic<std::uint64_t> starts_{0};
};

}  // namespace egofocus::hil
