// The library's own ego-motion on what the simulated robots say: bus -> candump text -> decoders -> filter,
// against the trajectory's true camera motion.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "citysim/can_bus.hpp"
#include "citysim/robots.hpp"
#include "hal/can_motion_decoder.hpp"
#include "hal/candump_decoder.hpp"
#include "pipeline/ego_motion.hpp"

using namespace egofocus;
using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

namespace {

constexpr double kDuration_s = 60;
constexpr double kSettled_s = 3;  // nothing is compared before
constexpr std::int64_t kTick_us = 50000;
constexpr std::int64_t kLateness_us = 30000;

struct Errors {
  std::vector<double> velocity;  // relative
  std::vector<double> rate_rad_s;
  double turned_rad = 0;  // of the camera, while compared
  double dropout_s = 0;
  std::uint64_t rejected = 0;
  std::uint64_t late = 0;
};

double norm(double x, double y, double z) {
  return std::sqrt(x * x + y * y + z * z);
}

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

std::vector<CanFrame> decoded(const std::string& text) {
  std::vector<CanFrame> frames(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')));
  CandumpDecoder decoder;
  const Decoded done = decoder.feed(std::as_bytes(std::span(text)), frames);
  REQUIRE(done.produced == frames.size());
  REQUIRE(decoder.counters().out_of_order == 0);
  return frames;
}

void compare(const CameraMotion& motion, const RigidState& truth, double slow_m_s, Errors& errors) {
  const sim::Vec3& v = truth.velocity_m_s;
  const sim::Vec3& w = truth.rate_rad_s;
  const double speed = norm(v[0], v[1], v[2]);
  errors.turned_rad += norm(w[0], w[1], w[2]) * 1e-6 * static_cast<double>(kTick_us);
  errors.rate_rad_s.push_back(norm(motion.angular_rate_rad_s[0] - w[0], motion.angular_rate_rad_s[1] - w[1],
                                   motion.angular_rate_rad_s[2] - w[2]));
  if (speed <= slow_m_s) return;
  errors.velocity.push_back(
      norm(motion.velocity_m_s[0] - v[0], motion.velocity_m_s[1] - v[1], motion.velocity_m_s[2] - v[2]) /
      speed);
}

void follow(Robot robot, std::uint64_t seed, double slow_m_s, Errors& errors) {
  const Trajectory trajectory = move(robot, kDuration_s, seed);
  const Mount mount = camera_of(robot);
  const MotionBus bus =
      motion_bus(trajectory, bus_of(robot), draw_bus_faults(bus_of(robot), seed), mount, seed);
  for (const auto& [from_us, to_us] : bus.dropouts_us)
    errors.dropout_s += static_cast<double>(to_us - from_us) * 1e-6;

  const auto dbc = std::make_unique<Dbc>();
  REQUIRE(read_dbc(bus.dbc, {}, *dbc).ok());
  const auto decoder = std::make_unique<CanMotionDecoder>();
  REQUIRE(decoder->configure(bus.can, *dbc).ok());
  REQUIRE(EgoMotion::check(bus.motion).ok());
  const auto ego = std::make_unique<EgoMotion>(bus.motion);

  const std::vector<CanFrame> frames = decoded(candump_text(bus.frames));
  std::size_t next = 0;
  MotionSamples samples;
  const auto end_us = static_cast<std::int64_t>(kDuration_s * 1e6);
  for (std::int64_t tick_us = kTick_us; tick_us <= end_us; tick_us += kTick_us) {
    for (; next < frames.size() && frames[next].t_us <= tick_us + kLateness_us; ++next) {
      decoder->feed(frames[next], samples);
      for (std::size_t i = 0; i < samples.imu_count; ++i) ego->add(samples.imu[i]);
      for (std::size_t i = 0; i < samples.odometry_count; ++i) ego->add(samples.odometry[i]);
    }
    ego->advance(tick_us);
    const double t_s = static_cast<double>(tick_us) * 1e-6;
    if (t_s >= kSettled_s)
      compare(ego->at_end(tick_us), camera_on(trajectory.body_at(t_s), mount), slow_m_s, errors);
  }
  errors.rejected += ego->odometry_counters().rejected;
  errors.late += ego->odometry_counters().late + ego->imu_counters().late;
}

}  // namespace

TEST_CASE("the ego-motion filter stays within 3 % velocity error, dropouts and turns included") {
  for (const Robot robot : kRobots) {
    const double slow_m_s = robot == Robot::kSlider || robot == Robot::kArm ? 0.1 : 0.5;
    Errors errors;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      Errors one;
      follow(robot, seed, slow_m_s, one);
      WARN("   " << name_of(robot) << " " << seed << ": n " << one.velocity.size() << " rms "
                 << (one.velocity.empty() ? 0 : 100 * rms(one.velocity)) << " p99 "
                 << (one.velocity.empty() ? 0 : 100 * quantile(one.velocity, .99)) << " rate rms "
                 << rms(one.rate_rad_s) << " rejected " << one.rejected << " dropout " << one.dropout_s);
      follow(robot, seed, slow_m_s, errors);
    }
    const double velocity_rms = 100 * rms(errors.velocity);
    const double velocity_99 = 100 * quantile(errors.velocity, 0.99);
    WARN(name_of(robot) << ": velocity error " << velocity_rms << " % rms, " << velocity_99
                        << " % at 99 %, worst " << 100 * quantile(errors.velocity, 1) << " % of speeds above "
                        << slow_m_s << " m/s (" << errors.velocity.size() << " ticks); rate error "
                        << rms(errors.rate_rad_s) << " rad/s rms, " << quantile(errors.rate_rad_s, 0.99)
                        << " at 99 %; turned " << errors.turned_rad << " rad, odometry silent for "
                        << errors.dropout_s << " s, rejected " << errors.rejected);
    CHECK(errors.late == 0);
    CHECK(velocity_rms < 3);
    CHECK(velocity_99 < 3);
  }
}
