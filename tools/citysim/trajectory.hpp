// Where the robot is: uniform cubic B-splines of position and of yaw, pitch and roll, so that velocity, rate
// and acceleration are their exact derivatives.
//
// World: x east, y north, z up, metres. Body: x forward, y left, z up (ISO 8855).
// Camera: x right, y down, z forward.
#pragma once

#include <vector>

#include "citysim/vec3.hpp"

namespace egofocus::citysim {

using namespace sim;  // vectors are std::array: their operators are not found by argument

/// p_world = rotation * p_own + position.
struct Pose {
  Mat3 rotation = sim::kIdentity;
  Vec3 position{0, 0, 0};
};

/// A rigid body at one time; velocities and accelerations in its own frame.
struct RigidState {
  Pose pose;
  Vec3 velocity_m_s{0, 0, 0};        ///< of its origin
  Vec3 rate_rad_s{0, 0, 0};          ///< angular
  Vec3 acceleration_m_s2{0, 0, 0};   ///< of its origin, without gravity
  Vec3 rate_change_rad_s2{0, 0, 0};  ///< derivative of the rate
};

/// Of the camera in the body: p_body = rotation * p_camera + position.
struct Mount {
  Mat3 rotation = sim::kIdentity;
  Vec3 position{0, 0, 0};
};

class Trajectory {
 public:
  /// One control point of each spline. Angles in radians, not wrapped: R = Rz(yaw) Ry(pitch) Rx(roll) with
  /// pitch positive nose down (ISO 8855), |pitch| < 1.4.
  struct Control {
    Vec3 position;
    double yaw = 0;
    double pitch = 0;
    double roll = 0;
  };

  /// Time 0 belongs to control point 1; at least 4 points, all finite. The curve does not pass through its
  /// control points, but stays in the convex hull of each four neighbours. Throws std::invalid_argument.
  Trajectory(std::vector<Control> controls, double interval_s);

  [[nodiscard]] double duration_s() const;
  /// `t_s` is limited to [0, duration_s].
  [[nodiscard]] RigidState body_at(double t_s) const;
  /// The splines' own values: the body's position and angles, not wrapped. `t_s` as above.
  [[nodiscard]] Control control_at(double t_s) const;

 private:
  struct Segment {
    const Control* controls;  // the first of four
    double u;                 // 0..1
  };
  [[nodiscard]] Segment segment_at(double t_s) const;

  std::vector<Control> controls_;
  double interval_s_;
};

/// The camera on that body: lever arm, its centripetal and tangential acceleration included.
[[nodiscard]] RigidState camera_on(const RigidState& body, const Mount& mount);

}  // namespace egofocus::citysim
