#include "pipeline/event_filter.hpp"

namespace egofocus {
namespace {

// Far below any time stamp, and far enough from INT64_MIN that differences do not overflow.
constexpr std::int64_t kNever = INT64_MIN / 4;

enum Heat : std::uint8_t { kCold, kGiven, kLearnt };
constexpr std::uint32_t kStretches = 1u << 8;
constexpr std::uint32_t kCounts = 1u << 24;

}  // namespace

Status EventFilter::check(const Config& config) noexcept {
  const FilterConfig& f = config.filter;
  const auto bad_time = [](std::int64_t t) { return t < 0 || t > 10'000'000; };
  if (bad_time(f.refractory_us))
    return {StatusCode::kBadFilter, "filter.refractory_us", f.refractory_us, 10'000'000};
  if (bad_time(f.isolated_us))
    return {StatusCode::kBadFilter, "filter.isolated_us", f.isolated_us, 10'000'000};
  if (f.hot_pixel_rate_hz < 0)
    return {StatusCode::kBadFilter, "filter.hot_pixel_rate_hz", f.hot_pixel_rate_hz};
  if (f.hot_pixel_rate_hz > 0 && (f.hot_pixel_learn_us < 1000 || f.hot_pixel_learn_us > 60'000'000)) {
    return {StatusCode::kBadFilter, "filter.hot_pixel_learn_us", f.hot_pixel_learn_us, 60'000'000};
  }
  if (f.hot_pixel_rate_hz > 0 && f.hot_pixel_rate_hz * f.hot_pixel_learn_us < 1'000'000) {
    // Less than one event in the time of learning: every pixel would be hot.
    return {StatusCode::kBadFilter, "filter.hot_pixel_rate_hz is too low for hot_pixel_learn_us",
            f.hot_pixel_rate_hz};
  }
  for (const Pixel& pixel : f.hot_pixels) {
    if (pixel.x >= config.camera.intrinsics.width_px)
      return {StatusCode::kBadFilter, "filter.hot_pixels x", pixel.x};
    if (pixel.y >= config.camera.intrinsics.height_px)
      return {StatusCode::kBadFilter, "filter.hot_pixels y", pixel.y};
  }
  return {};
}

EventFilter::EventFilter(const Config& config, Arena& arena) noexcept
    : config_(config.filter),
      width_(config.camera.intrinsics.width_px),
      height_(config.camera.intrinsics.height_px),
      hot_count_limit_(config.filter.hot_pixel_rate_hz * config.filter.hot_pixel_learn_us / 1'000'000) {
  const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  const auto bordered = static_cast<std::size_t>(width_ + 2) * static_cast<std::size_t>(height_ + 2);
  if (config_.refractory_us > 0) last_kept_us_ = arena.array<std::int64_t>(pixels);
  if (config_.isolated_us > 0) last_seen_us_ = arena.array<std::int64_t>(bordered);
  if (config_.hot_pixel_rate_hz > 0) learn_count_ = arena.array<std::uint32_t>(pixels);
  if (config_.hot_pixel_rate_hz > 0 || !config_.hot_pixels.empty()) hot_ = arena.array<std::uint8_t>(pixels);
  for (std::int64_t& t : last_kept_us_) t = kNever;
  for (std::int64_t& t : last_seen_us_) t = kNever;
  if (!hot_.empty()) {
    for (const Pixel& p : config_.hot_pixels)
      hot_[static_cast<std::size_t>(p.y) * static_cast<std::size_t>(width_) + p.x] = kGiven;
  }
  config_.hot_pixels = {};  // the caller's memory is not ours after set-up
}

bool EventFilter::keep(const Event& event) noexcept {
  if (event.x >= width_ || event.y >= height_) {
    ++counters_.out_of_range;
    return false;
  }
  if (event.t_us < newest_us_) {
    ++counters_.out_of_order;
    return false;
  }
  newest_us_ = event.t_us;
  const std::size_t pixel = static_cast<std::size_t>(event.y) * static_cast<std::size_t>(width_) + event.x;
  if (!hot_.empty() && is_hot(pixel, event.t_us)) {
    ++counters_.hot_pixel;
    return false;
  }
  if (!last_kept_us_.empty() && event.t_us - last_kept_us_[pixel] < config_.refractory_us) {
    ++counters_.refractory;
    return false;
  }
  if (!last_seen_us_.empty() && is_isolated(event)) {
    ++counters_.isolated;
    return false;
  }
  if (!last_kept_us_.empty()) last_kept_us_[pixel] = event.t_us;
  ++counters_.kept;
  return true;
}

// Each stretch of hot_pixel_learn_us counts by itself: a pixel is hot from the event that is one too many to
// the end of the next stretch, and on as long as it goes on so. Counts are begun anew when a pixel fires, so
// that a stretch's end costs nothing; one that was silent for just 256 stretches goes on with its old count.
bool EventFilter::is_hot(std::size_t pixel, std::int64_t t_us) noexcept {
  if (learn_count_.empty()) return hot_[pixel] != kCold;
  if (learn_until_us_ == INT64_MIN) learn_until_us_ = t_us + config_.hot_pixel_learn_us;
  if (t_us >= learn_until_us_) {
    const std::int64_t passed = (t_us - learn_until_us_) / config_.hot_pixel_learn_us + 1;
    stretch_ = (stretch_ + static_cast<std::uint32_t>(passed)) % kStretches;
    learn_until_us_ += passed * config_.hot_pixel_learn_us;
  }
  std::uint32_t stretch = learn_count_[pixel] / kCounts;
  std::uint32_t count = learn_count_[pixel] % kCounts;
  if (stretch != stretch_) {
    const bool was_last = (stretch + 1) % kStretches == stretch_;
    if (hot_[pixel] == kLearnt && !(was_last && count > hot_count_limit_)) hot_[pixel] = kCold;
    stretch = stretch_;
    count = 0;
  }
  if (count + 1 < kCounts) ++count;
  learn_count_[pixel] = stretch * kCounts + count;
  if (count > hot_count_limit_ && hot_[pixel] == kCold) hot_[pixel] = kLearnt;
  return hot_[pixel] != kCold;
}

bool EventFilter::is_isolated(const Event& event) noexcept {
  const auto stride = static_cast<std::size_t>(width_ + 2);
  const std::size_t centre = (static_cast<std::size_t>(event.y) + 1) * stride + event.x + 1;
  const std::int64_t since = event.t_us - config_.isolated_us;
  bool company = false;
  for (const std::size_t row : {centre - stride, centre, centre + stride}) {
    for (const std::size_t at : {row - 1, row, row + 1})
      company |= at != centre && last_seen_us_[at] >= since;
  }
  last_seen_us_[centre] = event.t_us;
  return !company;
}

}  // namespace egofocus
