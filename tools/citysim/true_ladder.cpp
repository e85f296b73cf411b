#include "citysim/true_ladder.hpp"

#include <vector>

namespace egofocus::citysim {

HypothesisLadder true_ladder(const World& world, std::int64_t end_us) {
  constexpr int kSteps = kLongestWindowUs / 10000;
  std::vector<MotionSample> motion;
  for (int i = 0; i <= kSteps; ++i) {
    MotionSample at;
    at.t_us = end_us - kLongestWindowUs + kLongestWindowUs * i / kSteps;
    const RigidState state = world.camera_at(1e-6 * static_cast<double>(at.t_us));
    for (std::size_t k = 0; k < 3; ++k) {
      at.velocity_m_s[k] = state.velocity_m_s[k];
      at.angular_rate_rad_s[k] = state.rate_rad_s[k];
    }
    motion.push_back(at);
  }
  MotionTrack track;
  integrate_track(motion, end_us - kLongestWindowUs, end_us, track);
  LadderConfig config;
  config.z_near_m = world.z_near_m;
  return choose_ladder(config, world.grid, track);
}

}  // namespace egofocus::citysim
