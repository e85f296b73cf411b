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
constexpr std::uint64_t kSeeds = 3;
constexpr double kSettled_s = 3;  // nothing is compared before
constexpr std::int64_t kTick_us = 50000;
constexpr std::int64_t kLateness_us = 30000;

struct Errors {
  std::vector<double> velocity;  // relative, at the filter's newest sample
  std::vector<double> rate_rad_s;
  std::vector<double> held;  // relative velocity error at the tick: the newest sample's, held
  double turned_rad = 0;     // of the camera, while compared
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

double distance(const double (&a)[3], const sim::Vec3& b) {
  return norm(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

double speed_of(const RigidState& state) {
  return norm(state.velocity_m_s[0], state.velocity_m_s[1], state.velocity_m_s[2]);
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
    if (static_cast<double>(tick_us) < kSettled_s * 1e6) continue;
    const auto truth_at = [&](std::int64_t t_us) {
      return camera_on(trajectory.body_at(static_cast<double>(t_us) * 1e-6), mount);
    };
    const CameraMotion newest = ego->filter().camera_motion();
    const RigidState truth = truth_at(newest.t_us);
    const double speed = speed_of(truth);
    errors.rate_rad_s.push_back(distance(newest.angular_rate_rad_s, truth.rate_rad_s));
    errors.turned_rad += norm(truth.rate_rad_s[0], truth.rate_rad_s[1], truth.rate_rad_s[2]) * 1e-6 *
                         static_cast<double>(kTick_us);
    if (speed <= slow_m_s) continue;
    errors.velocity.push_back(distance(newest.velocity_m_s, truth.velocity_m_s) / speed);
    const RigidState now = truth_at(tick_us);
    errors.held.push_back(distance(ego->at_end(tick_us).velocity_m_s, now.velocity_m_s) / speed);
  }
  errors.rejected += ego->odometry_counters().rejected;
  errors.late += ego->odometry_counters().late + ego->imu_counters().late;
}

}  // namespace

TEST_CASE("the ego-motion filter stays within 3 % velocity error, dropouts and turns included") {
  for (const Robot robot : kRobots) {
    const bool desk = robot == Robot::kSlider || robot == Robot::kArm;
    const double slow_m_s = desk ? 0.2 : 0.5;
    Errors errors;
    for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) follow(robot, seed, slow_m_s, errors);
    const double velocity_rms = 100 * rms(errors.velocity);
    const double velocity_99 = 100 * quantile(errors.velocity, 0.99);
    const double held_rms = 100 * rms(errors.held);
    WARN(name_of(robot) << ": velocity error " << velocity_rms << " % rms, " << velocity_99
                        << " % at 99 %, worst " << 100 * quantile(errors.velocity, 1) << " % of speeds above "
                        << slow_m_s << " m/s (" << errors.velocity.size() << " ticks); held until the tick "
                        << held_rms << " % rms, " << 100 * quantile(errors.held, 0.99)
                        << " % at 99 %; rate error " << rms(errors.rate_rad_s) << " rad/s rms, "
                        << quantile(errors.rate_rad_s, 0.99) << " at 99 %; turned " << errors.turned_rad
                        << " rad, odometry silent for " << errors.dropout_s << " s, rejected "
                        << errors.rejected);
    CHECK(errors.late == 0);
    CHECK(errors.rejected == 0);
    CHECK(errors.velocity.size() > 100 * kSeeds);
    CHECK(errors.dropout_s > 1);
    CHECK(velocity_rms < 3);
    CHECK(velocity_99 < 3);
    CHECK(held_rms < 3);
    CHECK(rms(errors.rate_rad_s) < 0.01);
    if (robot != Robot::kSlider) CHECK(errors.turned_rad > 1);
  }
}
