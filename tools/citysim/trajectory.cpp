#include "citysim/trajectory.hpp"

#include <array>
#include <stdexcept>

#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

using sim::cross;
using sim::transpose;

/// Weights of four neighbouring control points: of the value, and of its first and second derivative.
struct Weights {
  std::array<double, 4> value;
  std::array<double, 4> slope;
  std::array<double, 4> bend;
};

Weights weights_at(double u, double interval_s) {
  const double w = 1.0 - u;
  const double per_s = 1.0 / interval_s;
  const double per_s2 = per_s * per_s;
  return {{w * w * w / 6.0, (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0,
           (-3.0 * u * u * u + 3.0 * u * u + 3.0 * u + 1.0) / 6.0, u * u * u / 6.0},
          {-0.5 * w * w * per_s, (1.5 * u * u - 2.0 * u) * per_s, (-1.5 * u * u + u + 0.5) * per_s,
           0.5 * u * u * per_s},
          {w * per_s2, (3.0 * u - 2.0) * per_s2, (1.0 - 3.0 * u) * per_s2, u * per_s2}};
}

/// Position, then yaw, pitch and roll.
using Six = std::array<double, 6>;

Six weighted(const Trajectory::Control* controls, const std::array<double, 4>& weights) {
  Six sum{};
  for (std::size_t k = 0; k < 4; ++k) {
    const Trajectory::Control& c = controls[k];
    const Six all{c.position[0], c.position[1], c.position[2], c.yaw, c.pitch, c.roll};
    for (std::size_t i = 0; i < 6; ++i) sum[i] += weights[k] * all[i];
  }
  return sum;
}

bool finite(double x) {
  return x - x == 0;
}

}  // namespace

Trajectory::Trajectory(std::vector<Control> controls, double interval_s)
    : controls_(std::move(controls)), interval_s_(interval_s) {
  if (controls_.size() < 4) throw std::invalid_argument("a trajectory needs 4 control points or more");
  if (!finite(interval_s) || interval_s <= 0)
    throw std::invalid_argument("a trajectory's interval must be positive");
  for (const Control& c : controls_) {
    const double sum = c.position[0] + c.position[1] + c.position[2] + c.yaw + c.roll;
    if (!finite(sum)) throw std::invalid_argument("a trajectory's control point is not finite");
    if (!(absolute(c.pitch) < 1.4))
      throw std::invalid_argument("a trajectory's pitch must stay below 1.4 rad");
  }
}

double Trajectory::duration_s() const {
  return static_cast<double>(controls_.size() - 3) * interval_s_;
}

Trajectory::Segment Trajectory::segment_at(double t_s) const {
  const double last = static_cast<double>(controls_.size() - 4);
  const double at = (t_s > 0 ? t_s : 0) / interval_s_;
  const double whole = at < last ? floor_of(at) : last;
  return {controls_.data() + static_cast<std::size_t>(whole), at - whole < 1.0 ? at - whole : 1.0};
}

Trajectory::Control Trajectory::control_at(double t_s) const {
  const Segment segment = segment_at(t_s);
  const Six value = weighted(segment.controls, weights_at(segment.u, interval_s_).value);
  return {{value[0], value[1], value[2]}, value[3], value[4], value[5]};
}

RigidState Trajectory::body_at(double t_s) const {
  const auto [controls, u] = segment_at(t_s);
  const Weights w = weights_at(u, interval_s_);
  const Six value = weighted(controls, w.value);
  const Six slope = weighted(controls, w.slope);
  const Six bend = weighted(controls, w.bend);

  const double sy = sine(value[3]);
  const double cy = cosine(value[3]);
  const double sp = sine(value[4]);
  const double cp = cosine(value[4]);
  const double sr = sine(value[5]);
  const double cr = cosine(value[5]);
  const double yaw1 = slope[3];
  const double pitch1 = slope[4];
  const double roll1 = slope[5];
  const double yaw2 = bend[3];
  const double pitch2 = bend[4];
  const double roll2 = bend[5];

  RigidState state;
  state.pose.rotation = {{{cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr},
                          {sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr},
                          {-sp, cp * sr, cp * cr}}};
  state.pose.position = {value[0], value[1], value[2]};
  const sim::Mat3 to_body = transpose(state.pose.rotation);
  state.velocity_m_s = to_body * Vec3{slope[0], slope[1], slope[2]};
  state.acceleration_m_s2 = to_body * Vec3{bend[0], bend[1], bend[2]};
  state.rate_rad_s = {roll1 - yaw1 * sp, pitch1 * cr + yaw1 * cp * sr, -pitch1 * sr + yaw1 * cp * cr};
  // The derivatives of those three, term by term.
  state.rate_change_rad_s2 = {
      roll2 - yaw2 * sp - yaw1 * pitch1 * cp,
      (pitch2 * cr - pitch1 * roll1 * sr) + yaw2 * cp * sr + yaw1 * (roll1 * cp * cr - pitch1 * sp * sr),
      (-pitch2 * sr - pitch1 * roll1 * cr) + yaw2 * cp * cr - yaw1 * (roll1 * cp * sr + pitch1 * sp * cr)};
  return state;
}

RigidState camera_on(const RigidState& body, const Mount& mount) {
  const Vec3& arm = mount.position;
  const Vec3& rate = body.rate_rad_s;
  const sim::Mat3 to_camera = transpose(mount.rotation);
  RigidState camera;
  camera.pose.rotation = body.pose.rotation * mount.rotation;
  camera.pose.position = body.pose.rotation * arm + body.pose.position;
  camera.velocity_m_s = to_camera * (body.velocity_m_s + cross(rate, arm));
  camera.rate_rad_s = to_camera * rate;
  camera.rate_change_rad_s2 = to_camera * body.rate_change_rad_s2;
  camera.acceleration_m_s2 = to_camera * (body.acceleration_m_s2 + cross(body.rate_change_rad_s2, arm) +
                                          cross(rate, cross(rate, arm)));
  return camera;
}

}  // namespace egofocus::citysim
