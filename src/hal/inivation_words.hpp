// What the streams of iniVation's cameras have in common: counters, time and what a word is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace egofocus {

/// Address words differ, the rest is the same. Sources: libcaer, src/davis.c and src/dvxplorer.c, the
/// translators of the data stream.
enum class InivationFormat : std::uint8_t { kDavis, kDvxplorer };

/// All that such a stream can get wrong, counted.
enum class InivationViolation : std::uint8_t {
  kUnknownWord,   ///< a code that the format does not define; skipped
  kBeforeTime,    ///< events before the first time stamp; dropped
  kOutOfRange,    ///< events whose row or column lies outside the sensor or is not known; dropped
  kTimeBackward,  ///< a time stamp before its predecessor; it and the events up to the next good one: dropped
  kTimeLeap,      ///< a time beyond 2^60 us; refused
  kImuIncomplete,  ///< an IMU sample with missing or surplus bytes; dropped
  kOddByte,        ///< a USB transfer with half a word at its end; the byte is dropped
};
inline constexpr std::size_t kInivationViolationKinds = 7;

/// Counts since construction. Each event that was in the stream is in `events` or in `dropped_events`.
struct InivationCounters {
  std::uint64_t events = 0;          ///< taken over, so given out or waiting for room
  std::uint64_t dropped_events = 0;  ///< the violations say why
  std::uint64_t imu_samples = 0;
  std::uint64_t triggers = 0;     ///< edges and pulses of the external input
  std::uint64_t frame_words = 0;  ///< of APS frames: skipped
  std::uint64_t time_resets = 0;
  std::array<std::uint64_t, kInivationViolationKinds> violations{};  ///< by InivationViolation

  [[nodiscard]] std::uint64_t operator[](InivationViolation kind) const noexcept {
    return violations[static_cast<std::size_t>(kind)];
  }
  void count(InivationViolation kind, std::uint64_t events_lost = 0) noexcept {
    ++violations[static_cast<std::size_t>(kind)];
    dropped_events += events_lost;
  }
};

/// Time stamps of 15 bits and wrap words, unwrapped to 64 bits. Thread: one. RT: yes.
class InivationTime {
 public:
  [[nodiscard]] std::int64_t us() const noexcept { return now_us_; }
  /// A time has been read, and the newest one was no step back.
  [[nodiscard]] bool is_good() const noexcept { return is_known_ && !is_backward_; }
  [[nodiscard]] bool is_known() const noexcept { return is_known_; }

  void stamp(std::uint32_t low, InivationCounters& counters) noexcept {
    const std::int64_t t_us = wrap_us_ + low;
    is_backward_ = is_known_ && t_us < now_us_;
    if (is_backward_) {
      counters.count(InivationViolation::kTimeBackward);
      return;
    }
    now_us_ = t_us;
    is_known_ = true;
  }
  void wrap(std::uint32_t times, InivationCounters& counters) noexcept {
    const std::int64_t wrap_us = wrap_us_ + std::int64_t{0x8000} * times;
    if (wrap_us > kLatest_us) {
      counters.count(InivationViolation::kTimeLeap);
      return;
    }
    wrap_us_ = wrap_us;
    if (wrap_us_ > now_us_) now_us_ = wrap_us_;
    is_known_ = true;
    is_backward_ = false;
  }
  void reset() noexcept {
    wrap_us_ = now_us_ = 0;
    is_known_ = true;
    is_backward_ = false;
  }

 private:
  static constexpr std::int64_t kLatest_us = std::int64_t{1} << 60;
  std::int64_t wrap_us_ = 0;
  std::int64_t now_us_ = 0;
  bool is_known_ = false;
  bool is_backward_ = false;
};

}  // namespace egofocus
