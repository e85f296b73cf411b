#include "citysim/drive.hpp"

#include <stdexcept>

#include "citysim/shake.hpp"
#include "citysim/speed_plan.hpp"
#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

using sim::Random;

constexpr double kStep_s = 0.01;
constexpr double kLead_s = 2.0;  // before time 0, for filters to settle
constexpr double kTwoPi = 6.28318530717958647692;

/// A mass on a spring and a damper that follows what pushes it.
class Sway {
 public:
  explicit Sway(double hz) : rate_(kTwoPi * hz) {}
  double follow(double goal) {
    const double pull = rate_ * rate_ * (goal - value_) - 2 * kDamping * rate_ * speed_;
    speed_ += kStep_s * pull;
    value_ += kStep_s * speed_;
    return value_;
  }

 private:
  static constexpr double kDamping = 0.4;
  double rate_;
  double value_ = 0;
  double speed_ = 0;
};

}  // namespace

DriveStyle drive_style(Vehicle vehicle, std::uint64_t seed) {
  Random random(seed, "drive style");
  DriveStyle style;
  style.acceleration_m_s2 = random.uniform(1.5, 3.2);
  style.braking_m_s2 = random.uniform(1.8, 3.5);
  style.lateral_m_s2 = random.uniform(1.5, 3.0);
  style.stop_every_m = random.log_uniform(100, 500);
  const double rough = random.log_uniform(0.4, 1.8);
  style.heave_m_s = 0.018 * rough;
  style.rock_rad_s = 0.02 * rough;
  if (vehicle == Vehicle::kCar) return style;

  style.max_speed_m_s = random.uniform(1.2, 3.0);
  style.acceleration_m_s2 = random.uniform(0.6, 1.5);
  style.braking_m_s2 = random.uniform(0.6, 1.5);
  style.lateral_m_s2 = random.uniform(0.8, 1.8);
  style.max_yaw_rate_rad_s = random.uniform(0.9, 1.5);
  style.smoothing_s = 0.16;
  style.stop_every_m = random.log_uniform(10, 60);
  style.path.corner_radius_m = random.uniform(0.7, 1.6);
  style.path.turns_in_place = true;
  style.path.in_place_chance = 0.1;
  style.path.wander_spacing_m = 4;
  style.path.wander_half_width = 0.3;
  style.pitch_rad_per_m_s2 = 0.006;
  style.roll_rad_per_m_s2 = 0.006;
  style.sway_hz = 3;
  style.slip_s2_per_m = 0.002;
  style.heave_m_s = 0.012 * rough;
  style.rock_rad_s = 0.05 * rough;
  if (vehicle == Vehicle::kDeliveryRobot) return style;

  style.max_speed_m_s = random.uniform(1.4, 2.0);
  style.hesitation = 0.25;
  style.path.corner_radius_m = random.uniform(0.4, 0.9);
  style.path.in_place_chance = 0.3;
  style.stop_every_m = random.log_uniform(8, 40);
  style.pitch_rad_per_m_s2 = 0.002;
  style.roll_rad_per_m_s2 = 0.002;
  style.heave_m_s = 0.004 * rough;
  style.rock_rad_s = 0.015 * rough;
  return style;
}

Trajectory drive(const Ways& ways, const DriveStyle& style, double duration_s, std::uint64_t seed) {
  if (!(duration_s > 0 && duration_s <= 1000)) throw std::invalid_argument("a drive lasts up to 1000 s");
  Random path_random(seed, "drive path");
  Random plan_random(seed, "drive plan");
  Random road_random(seed, "drive road");
  const double need_m = style.max_speed_m_s * (duration_s + 2 * kLead_s) + 10;
  const DrivePath path(ways.route, style.path, need_m, path_random);

  const auto lead = static_cast<std::size_t>(kLead_s / kStep_s);
  const std::size_t controls_wanted = static_cast<std::size_t>(duration_s / kStep_s + 0.999999) + 3;
  const std::size_t n = controls_wanted + 2 * lead;
  const std::vector<double> progress = plan_progress(path, style, kStep_s, kLead_s, n, plan_random);

  std::vector<DrivePath::Place> places(n);
  for (std::size_t i = 0; i < n; ++i) places[i] = path.at(progress[i]);
  const auto speed_at = [&](std::size_t i) {
    return places[i].in_place ? 0.0 : (progress[i + 1] - progress[i - 1]) / (2 * kStep_s);
  };

  const Shake heave(road_random, 1.5, 14);
  const Shake pitch_rock(road_random, 1.2, 14);
  const Shake roll_rock(road_random, 1.0, 12);
  Sway pitch(style.sway_hz);
  Sway roll(style.sway_hz * 0.9);
  std::vector<Trajectory::Control> controls;
  for (std::size_t i = 2; i + 2 < n && controls.size() < controls_wanted; ++i) {
    const double speed = speed_at(i);
    const double forward_m_s2 = (speed_at(i + 1) - speed_at(i - 1)) / (2 * kStep_s);
    const double yaw_rate = (places[i + 1].yaw - places[i - 1].yaw) / (2 * kStep_s);
    const double left_m_s2 = speed * yaw_rate;
    const double swayed_pitch = pitch.follow(-style.pitch_rad_per_m_s2 * forward_m_s2);
    const double swayed_roll = roll.follow(style.roll_rad_per_m_s2 * left_m_s2);
    if (i + 1 < lead) continue;  // control point 1 is at time 0
    const double t = static_cast<double>(i) * kStep_s;
    const double rough = speed / (speed + 0.25 * style.max_speed_m_s);
    Trajectory::Control c;
    c.position = places[i].position;
    c.position[2] += rough * style.heave_m_s * heave.at(t);
    c.yaw = places[i].yaw + style.slip_s2_per_m * left_m_s2;
    c.pitch = -arc_tangent(places[i].slope) + swayed_pitch + rough * style.rock_rad_s * pitch_rock.at(t);
    c.roll = swayed_roll + rough * style.rock_rad_s * roll_rock.at(t);
    controls.push_back(c);
  }
  return {std::move(controls), kStep_s};
}

}  // namespace egofocus::citysim
