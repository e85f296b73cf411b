#include "pipeline/carried_depth.hpp"

#include "core/check.hpp"
#include "core/elementary.hpp"
#include "pipeline/depth_reprojection.hpp"

namespace egofocus {
namespace {

constexpr MotionKnot kStill{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};

/// `second` after `first`.
MotionKnot compose(const MotionKnot& second, const MotionKnot& first) noexcept {
  MotionKnot out;
  for (int row = 0; row < 3; ++row) {
    const double* const r = &second.rotation[3 * row];
    for (int column = 0; column < 3; ++column) {
      out.rotation[3 * row + column] = r[0] * first.rotation[column] + r[1] * first.rotation[3 + column] +
                                       r[2] * first.rotation[6 + column];
    }
    out.centre_m[row] =
        r[0] * first.centre_m[0] + r[1] * first.centre_m[1] + r[2] * first.centre_m[2] + second.centre_m[row];
  }
  return out;
}

}  // namespace

Status CarriedDepth::check(const CarryConfig& config) noexcept {
  constexpr std::int64_t kLongest_us = 600'000'000;
  if (config.max_age_us < 0 || config.max_age_us > kLongest_us)
    return {StatusCode::kBadCarry, "carry.max_age_us", config.max_age_us, kLongest_us};
  if (!(config.max_travel >= 0.01 && config.max_travel <= 1))
    return {StatusCode::kBadCarry, "carry.max_travel (0.01..1)", status_value(config.max_travel), 1};
  if (!(config.min_in_view >= 0 && config.min_in_view <= 1))
    return {StatusCode::kBadCarry, "carry.min_in_view (0..1)", status_value(config.min_in_view), 1};
  constexpr std::int64_t kLongestFuse_us = 10'000'000;
  if (config.fuse_us < 0 || config.fuse_us > kLongestFuse_us)
    return {StatusCode::kBadCarry, "carry.fuse_us", config.fuse_us, kLongestFuse_us};
  return {};
}

CarriedDepth::CarriedDepth(const CarryConfig& config, const Intrinsics& grid, std::span<std::uint32_t> landed,
                           Arena& arena) noexcept
    : config_(config), grid_(grid), landed_(landed) {
  if (config.max_age_us == 0) return;
  const auto pixels = static_cast<std::size_t>(grid.width_px) * static_cast<std::size_t>(grid.height_px);
  inverse_depth_ = arena.array<std::uint16_t>(pixels);
  confidence_ = arena.array<std::uint8_t>(pixels);
}

void CarriedDepth::keep(const DepthFrame& frame, std::int64_t newest_event_us) noexcept {
  if (config_.max_age_us == 0) return;
  if (kept_) {
    const double freshness =
        1.0 - static_cast<double>(newest_event_us - newest_event_us_) / static_cast<double>(kStrongerFor_us);
    if (frame.parallax_px < parallax_px_ * freshness) return;
  }
  EGOFOCUS_CHECK(frame.inverse_depth.size() == inverse_depth_.size());
  __builtin_memcpy(inverse_depth_.data(), frame.inverse_depth.data(), inverse_depth_.size_bytes());
  __builtin_memcpy(confidence_.data(), frame.confidence.data(), confidence_.size_bytes());
  std::uint32_t known_px = 0;
  for (const std::uint8_t confidence : confidence_) known_px += confidence != 0 ? 1 : 0;
  known_px_ = known_px;
  parallax_px_ = frame.parallax_px;
  scale_per_m_ = frame.inverse_depth_scale_per_m;
  flags_ = frame.flags;
  newest_event_us_ = newest_event_us;
  followed_us_ = frame.t_us;
  followed_ = kStill;
  kept_ = known_px_ > 0;
}

void CarriedDepth::follow(const MotionTrack& motion) noexcept {
  EGOFOCUS_CHECK(motion.begin_us == followed_us_);
  followed_ = compose(motion.knots[0], followed_);
  followed_us_ = motion.end_us;
}

bool CarriedDepth::show(const MotionTrack& motion, DepthFrame& frame, std::span<std::uint16_t> inverse_depth,
                        std::span<std::uint8_t> confidence) noexcept {
  if (!kept_) return false;
  EGOFOCUS_CHECK(motion.begin_us == followed_us_);
  const std::int64_t age_us = motion.end_us - newest_event_us_;
  if (age_us >= config_.max_age_us) {
    drop();
    return false;
  }
  // At least 1/256: what is shown has some confidence.
  const auto share_q8 = static_cast<std::uint32_t>(
      (256 * (config_.max_age_us - age_us) + config_.max_age_us - 1) / config_.max_age_us);
  const Reprojection by =
      reprojection(compose(motion.knots[0], followed_), grid_, scale_per_m_, config_.max_travel);
  const std::size_t in_view =
      reproject(by, grid_, share_q8, inverse_depth_, confidence_, landed_, inverse_depth, confidence);
  __builtin_memset(landed_.data(), 0, landed_.size_bytes());
  if (in_view == 0 || static_cast<double>(in_view) < config_.min_in_view * static_cast<double>(known_px_))
    return false;
  frame.flags |= kCarried;
  frame.inverse_depth_scale_per_m = scale_per_m_;
  return true;
}

}  // namespace egofocus
