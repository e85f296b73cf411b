// A camera path made of phases of constant twist with smooth ramps between them, integrated once on a fine
// grid.
#pragma once

#include <cstdint>
#include <vector>

#include "support/plane_scene.hpp"

namespace egofocus::sim {

/// Velocity and angular rate of the camera in its own frame (x right, y down, z forward).
struct Twist {
  Vec3 velocity_m_s{0, 0, 0};
  Vec3 rate_rad_s{0, 0, 0};
};

struct Phase {
  std::int64_t duration_us;
  Twist twist;
};

class Trajectory {
 public:
  static constexpr std::int64_t kStepUs = 500;
  static constexpr std::int64_t kRampUs = 100000;  ///< from the phase before, at the beginning of each phase

  /// Durations are multiples of kStepUs.
  Trajectory(const CameraPose& start, std::vector<Phase> phases);

  [[nodiscard]] std::int64_t duration_us() const { return duration_us_; }
  [[nodiscard]] Twist twist_at(std::int64_t t_us) const;
  /// `t_us` is a multiple of kStepUs in [0, duration_us].
  [[nodiscard]] const CameraPose& pose_at(std::int64_t t_us) const;

 private:
  std::vector<Phase> phases_;
  std::int64_t duration_us_ = 0;
  std::vector<CameraPose> poses_;  // each kStepUs
};

}  // namespace egofocus::sim
