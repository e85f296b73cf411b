// The last measured depth, seen from where the camera is now: what a tick shows that cannot measure. Nothing
// is measured anew, so it is right as long as the world stands still and the motion is known.
#pragma once

#include <cstdint>
#include <span>

#include "core/arena.hpp"
#include "egofocus/config.hpp"
#include "egofocus/status.hpp"
#include "egofocus/types.hpp"
#include "pipeline/motion_track.hpp"

namespace egofocus {

/// Thread: the tick's. RT: yes, but check() and the constructor.
class CarriedDepth {
 public:
  static constexpr std::int64_t kStrongerFor_us = 2'000'000;

  static Status check(const CarryConfig& config) noexcept;

  /// Takes 3 bytes per pixel of the grid from the arena; nothing where max_age_us is 0, and then nothing is
  /// ever kept. `landed`: one value per pixel, for show() alone; may be another's memory meanwhile, who finds
  /// it all zero. Precondition: check(config) is ok.
  CarriedDepth(const CarryConfig& config, const Intrinsics& grid, std::span<std::uint32_t> landed,
               Arena& arena) noexcept;

  /// Copies a measured frame, in place of the one before; but the last ticks before a standstill have the
  /// least parallax: a frame with more of it stays until it has aged, by so much less for each moment up to
  /// kStrongerFor_us. newest_event_us: what its age counts from.
  void keep(const DepthFrame& frame, std::int64_t newest_event_us) noexcept;
  /// For a break in the motion: where the camera is now, seen from the kept frame, is not known.
  void drop() noexcept { kept_ = false; }

  [[nodiscard]] bool kept() const noexcept { return kept_; }
  /// The kept frame rests on few events itself.
  [[nodiscard]] bool few_events() const noexcept { return (flags_ & kTooFewEvents) != 0; }
  /// The kept frame is known as seen from the camera at this time.
  [[nodiscard]] std::int64_t followed_us() const noexcept { return followed_us_; }

  /// The camera's motion from followed_us() on. Only motion that will not be known better later: what is held
  /// beyond the newest sample belongs to show(). Precondition: motion.begin_us == followed_us().
  void follow(const MotionTrack& motion) noexcept;

  /// The kept depth as seen at the end of `motion`, which begins at followed_us(). Sets the frame's scale,
  /// its arrays (which it views) and kCarried. False, with the arrays undefined: nothing is kept, it is older
  /// than max_age_us (and dropped), or too little of it is in view. Always from the kept frame itself:
  /// nothing adds up from tick to tick.
  bool show(const MotionTrack& motion, DepthFrame& frame, std::span<std::uint16_t> inverse_depth,
            std::span<std::uint8_t> confidence) noexcept;

 private:
  CarryConfig config_;
  Intrinsics grid_;
  std::span<std::uint16_t> inverse_depth_;
  std::span<std::uint8_t> confidence_;
  std::span<std::uint32_t> landed_;
  double scale_per_m_ = 0;
  double parallax_px_ = 0;
  std::size_t known_px_ = 0;
  std::uint32_t flags_ = 0;
  std::int64_t newest_event_us_ = 0;
  std::int64_t followed_us_ = 0;
  MotionKnot followed_{};  // from the kept frame's view to that of followed_us_
  bool kept_ = false;
};

}  // namespace egofocus
