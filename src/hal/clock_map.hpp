// A device's clock on the host's: the lower envelope of (device time, host time) pairs.
//
// A host sees a device time only after a transport delay, which is never negative and has a hard minimum. So
// the line host = offset + rate * device under all pairs is the clock, and a mean is not: it carries the mean
// delay, which changes with load. The line is the supporting line of the pairs' lower convex hull at their
// mean time. The constant minimum delay cannot be seen; it is a parameter of the set-up
// (`egofocus calibrate-time`).
//
// Method: S. Moon, P. Skelly, D. Towsley, "Estimation and removal of clock skew from network delay
// measurements", INFOCOM 1999; L. Zhang, Z. Liu, C. Xia, "Clock synchronization algorithms for network
// measurements", INFOCOM 2002 (the hull).
#pragma once

#include <cstddef>
#include <cstdint>

namespace egofocus {

/// Every pair is in `used` or in one of the lines below it.
struct ClockMapCounters {
  std::uint64_t pairs = 0;  ///< observe() calls
  std::uint64_t used = 0;
  std::uint64_t backwards = 0;  ///< device time a little before that of the pair before: left out
  std::uint64_t outliers = 0;   ///< more than kJumpUs off the line: left out, or waiting to become a jump
  std::uint64_t invalid = 0;    ///< a time beyond +-kMaxTimeUs
  std::uint64_t jumps = 0;      ///< times the map began anew because the clocks had jumped
  std::uint64_t resets = 0;     ///< reset() calls
};

/// Between two beginnings (jumps, reset()) the map is monotone and continuous: an observation changes it for
/// later device times only, and what it learns is blended in at kSlew at most (kFastSlew until settled).
///
/// Device times are unwrapped by the decoder. The clocks run at equal speed within kMaxRate. No pair for a
/// while: the line goes on. A jump is 4 pairs or more in a row that are off the line, agree among each other,
/// and last 0.5 s: the map then begins anew with the last of them. Pauses of any length are no jump as long
/// as the line still holds afterwards.
///
/// Thread: one at a time. RT: yes; observe() is O(1), with at most 3 * kBins steps once in kBinUs of device
/// time.
class ClockMap {
 public:
  static constexpr std::int64_t kMaxTimeUs = std::int64_t{1}
                                             << 52;  ///< 142 years: some clocks count from 1970
  static constexpr std::int64_t kBinUs = 250000;
  static constexpr std::size_t kBins = 128;   ///< 32 s of continuous pairs
  static constexpr double kMaxRate = 200e-6;  ///< crystals are within 100e-6, host slewing is beside it
  static constexpr double kSlew = 500e-6;     ///< change of the mapped time per time, beyond the rate
  static constexpr double kFastSlew = 0.1;    ///< the same until settled
  static constexpr std::int64_t kSettledUs = 2000000;  ///< of device time: from here on the rate is measured
  static constexpr std::int64_t kJumpUs = 20000;
  static constexpr std::int64_t kJumpLastsUs = 500000;    ///< on both clocks
  static constexpr std::int64_t kMaxPauseUs = 900000000;  ///< older pairs no longer count

  /// `device_us` was seen by the host at `host_us` (monotonic), so it happened then or before. For a
  /// transfer: its last event and its completion.
  void observe(std::int64_t device_us, std::int64_t host_us) noexcept;

  /// The host's time of a device time, past or (a little) to come. Without a pair: `device_us` itself. Times
  /// beyond +-kMaxTimeUs are limited to it. Monotone over calls in any order around observe(), as long as no
  /// time is asked for that lies after the next pair, or before the last but one.
  [[nodiscard]] std::int64_t to_host_us(std::int64_t device_us) const noexcept;

  /// Forgets everything but the counters: another device, or one whose clock was reset.
  void reset() noexcept;

  /// A pair was used since the beginning or reset().
  [[nodiscard]] bool begun() const noexcept { return begun_; }
  /// How much faster the host's clock runs than the device's, as measured so far; 0 before kSettledUs.
  [[nodiscard]] double drift_ppm() const noexcept { return rate_ * 1e6; }
  /// Pairs span kSettledUs or more since the beginning or the last jump.
  [[nodiscard]] bool settled() const noexcept { return settled_; }
  /// Transport delay of the last used pair beyond the smallest one.
  [[nodiscard]] std::int64_t delay_us() const noexcept { return delay_us_; }
  [[nodiscard]] const ClockMapCounters& counters() const noexcept { return counters_; }

 private:
  // A pair as seen from the base: x in device us, y = how far the host is ahead, in ns.
  struct Point {
    std::int64_t x_us = 0;
    std::int64_t y_ns = 0;
  };
  // The map from `from` on: the line, and what is left of the difference to the map before, which fades out.
  struct Piece {
    Point from;  // on the line
    double rate = 0;
    std::int64_t rest_ns = 0;
    std::int64_t fade_us = 1;
    [[nodiscard]] std::int64_t y_ns(std::int64_t x_us) const noexcept;
  };
  // Pairs off the line that may turn out to be a jump.
  struct Suspects {
    std::uint32_t count = 0;
    std::int64_t first_device_us = 0;
    std::int64_t first_host_us = 0;
    std::int64_t lowest_ns = 0;
    std::int64_t highest_ns = 0;
  };

  void begin(std::int64_t device_us, std::int64_t host_us) noexcept;
  [[nodiscard]] std::int64_t line_ns(std::int64_t x_us) const noexcept;
  void suspect(std::int64_t device_us, std::int64_t host_us, std::int64_t off_ns) noexcept;
  void add(const Point& point) noexcept;
  void close_bin() noexcept;
  void fit() noexcept;
  [[nodiscard]] double hull_rate() const noexcept;
  void bend(std::int64_t x_us) noexcept;
  [[nodiscard]] const Point& bin(std::size_t i) const noexcept { return bins_[(first_bin_ + i) % kBins]; }

  bool begun_ = false;
  bool settled_ = false;
  std::int64_t base_device_us_ = 0;
  std::int64_t base_ahead_us_ = 0;  // host - device of the first pair
  std::int64_t last_x_us_ = 0;
  std::int64_t delay_us_ = 0;
  double rate_ = 0;
  Point anchor_;  // the line goes through it
  Piece before_;  // the map up to now_.from
  Piece now_;
  Point bins_[kBins];  // the lowest pair of each closed bin, in time order from first_bin_
  std::size_t first_bin_ = 0;
  std::size_t bin_count_ = 0;
  Point open_;  // the lowest pair of the open bin
  std::int64_t open_since_us_ = 0;
  Suspects suspects_;
  ClockMapCounters counters_;
};

}  // namespace egofocus
