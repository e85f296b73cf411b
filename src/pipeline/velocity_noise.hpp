// Errors added on purpose to the measured motion (VelocityNoise in config.hpp).
#pragma once

#include <cstdint>
#include <span>

#include "egofocus/config.hpp"
#include "egofocus/status.hpp"
#include "pipeline/ego_motion.hpp"
#include "pipeline/motion_track.hpp"

namespace egofocus {

/// kBadMotion when percent is outside 0..1000. Thread: any. RT: no.
Status check_velocity_noise(const VelocityNoise& noise) noexcept;

/// Adds to each component of velocity (m/s) and angular rate (rad/s) of all samples of one window. The errors
/// are a function of (seed, tick_us, number of the sample, component) alone, and at most 6 sigma.
/// Thread: any. RT: yes, O(samples).
void add_velocity_noise(const VelocityNoise& noise, std::int64_t tick_us,
                        std::span<MotionSample> samples) noexcept;

/// EgoMotion::track() from begin_us to tick_us, through EgoMotion::kMaxSamples noisy samples from oldest_us
/// to tick_us: any begin_us of one tick meets the same errors. False where the motion since oldest_us is not
/// known; `out` is then untouched. Precondition: oldest_us <= begin_us <= tick_us. Thread: one. RT: yes.
bool noisy_track(const VelocityNoise& noise, const EgoMotion& ego_motion, std::int64_t oldest_us,
                 std::int64_t begin_us, std::int64_t tick_us, MotionTrack& out) noexcept;

}  // namespace egofocus
