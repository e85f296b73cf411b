// TIME_HIGH, the upper part of a device time: a counter of few bits that wraps and is sent now and then.
// Reading it means unwrapping; writing it means never leaving a gap that a reader could not unwrap.
#pragma once

#include <cstdint>

#include "hal/evt_violations.hpp"

namespace egofocus {

/// Unwraps a counter of `bits` bits. A step back by half the range or more is a wrap; any other step back,
/// and any leap ahead by half the range or more, is an error and refused (facts: EVT3, OpenEB's loop rule).
///
/// One corrupt word that was believed would then make every true one look wrong. So after kResetAfter
/// refusals in a row the sensor is believed, and time moves to the nearest value that fits, which may lie in
/// the past: that is what a restarted sensor looks like too, and whoever maps device time to host time sees
/// kTimeReset.
///
/// After data were lost, time is unknown until the next word that is not refused; the epoch stays.
class TimeHighReader {
 public:
  static constexpr std::uint32_t kResetAfter = 16;

  explicit constexpr TimeHighReader(int bits) noexcept : range_(std::int64_t{1} << bits) {}

  [[nodiscard]] bool known() const noexcept { return known_; }
  /// The unwrapped counter; while !known() the last one that was.
  [[nodiscard]] std::int64_t value() const noexcept { return value_; }
  /// Data were lost. Thread: one. RT: yes.
  void lose() noexcept { known_ = false; }

  /// Takes the counter of a TIME_HIGH word, 0 .. 2^bits - 1; true when value() changed. Thread: one. RT: yes.
  bool take(std::uint32_t counter, EvtCounters& counters) noexcept {
    if (!begun_) {
      begun_ = known_ = true;
      value_ = counter;
      return true;
    }
    const std::int64_t half = range_ / 2;
    const std::int64_t step = counter - (value_ & (range_ - 1));  // within one epoch: -range < step < range
    if (step > -half && step < 0) return refuse(EvtViolation::kTimeHighBackward, step, counters);
    if (step >= half) return refuse(EvtViolation::kTimeHighLeap, step - range_, counters);
    refused_ = 0;
    known_ = true;
    value_ += step < 0 ? step + range_ : step;
    return step != 0;
  }

 private:
  // `nearest` is the smallest step, always back, that explains the word.
  bool refuse(EvtViolation why, std::int64_t nearest, EvtCounters& counters) noexcept {
    counters.count(why);
    if (++refused_ < kResetAfter) return false;
    counters.count(EvtViolation::kTimeReset);
    refused_ = 0;
    known_ = true;
    value_ += nearest;
    return true;
  }

  std::int64_t range_;
  std::int64_t value_ = 0;
  std::uint32_t refused_ = 0;
  bool begun_ = false;
  bool known_ = false;
};

/// Says which TIME_HIGH words an encoder owes before it may write something of a given time. No step is
/// longer than a quarter of the range, so that silence of any length stays unambiguous.
class TimeHighWriter {
 public:
  explicit constexpr TimeHighWriter(int bits) noexcept : range_(std::int64_t{1} << bits) {}

  /// True: write `counter` first, then ask again. Precondition: can_reach(target). Thread: one. RT: yes.
  bool owes(std::int64_t target, std::uint32_t& counter) noexcept {
    if (value_ == target) return false;
    const std::int64_t longest =
        value_ < 0 ? range_ : value_ + range_ / 4 + 1;  // the first word may say anything
    value_ = target < longest ? target : longest - 1;
    counter = static_cast<std::uint32_t>(value_ & (range_ - 1));
    return true;
  }
  /// The format cannot go back, nor below zero; and a silence of 2^16 wraps is no recording but a mistake.
  [[nodiscard]] bool can_reach(std::int64_t target) const noexcept {
    return target >= 0 && target >= value_ && target - value_ < range_ * 65536;
  }

 private:
  std::int64_t range_;
  std::int64_t value_ = -1;  // the last one written; -1: none yet
};

}  // namespace egofocus
