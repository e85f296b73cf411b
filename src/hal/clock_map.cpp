#include "hal/clock_map.hpp"

namespace egofocus {
namespace {

constexpr std::int64_t kNano = 1000;  // ns per us
constexpr std::int64_t kFadeUs =
    250000;  // differences fade out over this time, or longer if kSlew asks for it
constexpr std::uint32_t kJumpPairs = 4;
constexpr std::int64_t kMaxAheadUs = std::int64_t{1} << 51;

bool is_out_of_range(std::int64_t t_us) noexcept {
  return t_us > ClockMap::kMaxTimeUs || t_us < -ClockMap::kMaxTimeUs;
}

std::int64_t limited(std::int64_t value, std::int64_t low, std::int64_t high) noexcept {
  return value < low ? low : value > high ? high : value;
}

// y of a line through `at`; x is at most 2^53 us away, so the product stays below 2^51 ns.
std::int64_t along(std::int64_t x_us, std::int64_t at_x_us, std::int64_t at_y_ns, double rate) noexcept {
  return at_y_ns + static_cast<std::int64_t>(static_cast<double>(x_us - at_x_us) * (rate * kNano));
}

// Neighbours are at least a bin apart.
template <typename Point>
double slope(const Point& a, const Point& b) noexcept {
  return static_cast<double>(b.y_ns - a.y_ns) / (static_cast<double>(b.x_us - a.x_us) * kNano);
}

std::int64_t floor_us(std::int64_t ns) noexcept {
  return ns / kNano - (ns % kNano < 0 ? 1 : 0);
}

}  // namespace

std::int64_t ClockMap::Piece::y_ns(std::int64_t x_us) const noexcept {
  const std::int64_t since = x_us - from.x_us;
  std::int64_t rest = rest_ns;
  if (since >= fade_us) {
    rest = 0;
  } else if (since > 0) {
    rest -= static_cast<std::int64_t>(static_cast<double>(rest_ns) * static_cast<double>(since) /
                                      static_cast<double>(fade_us));
  }
  return along(x_us, from.x_us, from.y_ns, rate) + rest;
}

void ClockMap::reset() noexcept {
  const ClockMapCounters kept = counters_;
  *this = ClockMap();
  counters_ = kept;
  ++counters_.resets;
}

// The rate stays: a clock that jumps is still the same crystal.
void ClockMap::begin(std::int64_t device_us, std::int64_t host_us) noexcept {
  begun_ = true;
  settled_ = false;
  base_device_us_ = device_us;
  base_ahead_us_ = host_us - device_us;
  last_x_us_ = 0;
  delay_us_ = 0;
  anchor_ = {};
  now_ = {};
  now_.rate = rate_;
  before_ = now_;
  first_bin_ = bin_count_ = 0;
  open_ = {};
  open_since_us_ = 0;
  suspects_ = {};
}

std::int64_t ClockMap::line_ns(std::int64_t x_us) const noexcept {
  return along(x_us, anchor_.x_us, anchor_.y_ns, rate_);
}

void ClockMap::observe(std::int64_t device_us, std::int64_t host_us) noexcept {
  ++counters_.pairs;
  if (is_out_of_range(device_us) || is_out_of_range(host_us)) {
    ++counters_.invalid;
    return;
  }
  if (!begun_) {
    begin(device_us, host_us);
    ++counters_.used;
    return;
  }
  // Far beyond any jump its size does not matter, but nanoseconds must fit.
  const std::int64_t ahead_us = limited(host_us - device_us - base_ahead_us_, -kMaxAheadUs, kMaxAheadUs);
  const Point point{device_us - base_device_us_, ahead_us * kNano};
  const std::int64_t off_ns = point.y_ns - line_ns(point.x_us);
  if (off_ns > kJumpUs * kNano || off_ns < -kJumpUs * kNano) {
    ++counters_.outliers;
    suspect(device_us, host_us, off_ns);
    return;
  }
  suspects_.count = 0;
  if (point.x_us < last_x_us_) {
    ++counters_.backwards;
    return;
  }
  ++counters_.used;
  last_x_us_ = point.x_us;
  delay_us_ = off_ns > 0 ? off_ns / kNano : 0;
  add(point);
  bend(point.x_us);
}

void ClockMap::suspect(std::int64_t device_us, std::int64_t host_us, std::int64_t off_ns) noexcept {
  Suspects& s = suspects_;
  const std::int64_t low = s.count > 0 && s.lowest_ns < off_ns ? s.lowest_ns : off_ns;
  const std::int64_t high = s.count > 0 && s.highest_ns > off_ns ? s.highest_ns : off_ns;
  const bool agrees = high - low <= kJumpUs * kNano && device_us >= s.first_device_us;
  if (s.count == 0 || !agrees) {
    s = {1, device_us, host_us, off_ns, off_ns};
    return;
  }
  s.lowest_ns = low;
  s.highest_ns = high;
  ++s.count;
  if (s.count < kJumpPairs || device_us - s.first_device_us < kJumpLastsUs ||
      host_us - s.first_host_us < kJumpLastsUs) {
    return;
  }
  begin(device_us, host_us);
  ++counters_.jumps;
}

void ClockMap::add(const Point& point) noexcept {
  if (point.x_us - open_since_us_ >= kBinUs) {
    close_bin();
    open_ = point;
    open_since_us_ = point.x_us;
    fit();
  } else if (point.y_ns - line_ns(point.x_us) < open_.y_ns - line_ns(open_.x_us)) {
    open_ = point;
  }
  // No pair lies below the line.
  if (point.y_ns < line_ns(point.x_us)) anchor_ = point;
}

void ClockMap::close_bin() noexcept {
  if (bin_count_ == kBins) {
    first_bin_ = (first_bin_ + 1) % kBins;
    --bin_count_;
  }
  bins_[(first_bin_ + bin_count_) % kBins] = open_;
  ++bin_count_;
}

void ClockMap::fit() noexcept {
  while (bin_count_ > 0 && open_.x_us - bin(0).x_us > kMaxPauseUs) {
    first_bin_ = (first_bin_ + 1) % kBins;
    --bin_count_;
  }
  if (bin_count_ == 0) return;  // after a long pause the line goes on until a pair lies below it
  if (open_.x_us - bin(0).x_us >= kSettledUs) {
    rate_ = hull_rate();
    settled_ = true;
  }
  // The lowest line of this rate.
  anchor_ = open_;
  for (std::size_t i = 0; i < bin_count_; ++i) {
    if (bin(i).y_ns < line_ns(bin(i).x_us)) anchor_ = bin(i);
  }
}

// Slope of the edge of the lower convex hull under the mean time.
double ClockMap::hull_rate() const noexcept {
  std::uint8_t hull[kBins];
  std::size_t size = 0;
  std::int64_t sum_us = 0;  // relative to the first
  for (std::size_t i = 0; i < bin_count_; ++i) {
    const Point& c = bin(i);
    sum_us += c.x_us - bin(0).x_us;
    for (; size >= 2; --size) {
      const Point& a = bin(hull[size - 2]);
      const Point& b = bin(hull[size - 1]);
      if (slope(a, c) > slope(a, b)) break;
    }
    hull[size++] = static_cast<std::uint8_t>(i);
  }
  const std::int64_t mean_us = bin(0).x_us + sum_us / static_cast<std::int64_t>(bin_count_);
  if (size < 2) return rate_;
  std::size_t right = 1;
  while (right + 1 < size && bin(hull[right]).x_us < mean_us) ++right;
  const Point& a = bin(hull[right - 1]);
  const Point& b = bin(hull[right]);
  const double rate = slope(a, b);
  return rate < -kMaxRate ? -kMaxRate : rate > kMaxRate ? kMaxRate : rate;
}

// The map follows the line from here on, and gets there without a step.
void ClockMap::bend(std::int64_t x_us) noexcept {
  Piece next;
  next.from = {x_us, line_ns(x_us)};
  next.rate = rate_;
  next.rest_ns = now_.y_ns(x_us) - next.from.y_ns;
  const double slew = settled_ ? kSlew : kFastSlew;
  const double rest_us = static_cast<double>(next.rest_ns < 0 ? -next.rest_ns : next.rest_ns) / kNano;
  next.fade_us = static_cast<std::int64_t>(rest_us / slew) + 1;
  if (next.fade_us < kFadeUs) next.fade_us = kFadeUs;
  before_ = now_;
  now_ = next;
}

std::int64_t ClockMap::to_host_us(std::int64_t device_us) const noexcept {
  if (!begun_) return device_us;
  const std::int64_t x_us = limited(device_us, -kMaxTimeUs, kMaxTimeUs) - base_device_us_;
  const Piece& piece = x_us < now_.from.x_us ? before_ : now_;
  return base_device_us_ + x_us + base_ahead_us_ + floor_us(piece.y_ns(x_us));
}

}  // namespace egofocus
