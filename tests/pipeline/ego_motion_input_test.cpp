// What comes in badly: late, out of order, missing, not finite, implausible; and motion from poses.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <variant>
#include <vector>

#include "pipeline/drive.hpp"
#include "pipeline/ego_motion.hpp"

using namespace egofocus;
using namespace egofocus::test;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool same(const CameraMotion& a, const CameraMotion& b) {
  bool equal = a.t_us == b.t_us;
  for (int i = 0; i < 3; ++i) {
    equal =
        equal && a.velocity_m_s[i] == b.velocity_m_s[i] && a.angular_rate_rad_s[i] == b.angular_rate_rad_s[i];
  }
  for (int i = 0; i < 6; ++i)
    equal = equal && a.velocity_covariance_m2_s2[i] == b.velocity_covariance_m2_s2[i];
  return equal;
}

/// A slide along x at 0.5 m/s that turns about z at 0.4 rad/s; 100 Hz from 1 s on.
PoseSample slide_pose(std::int64_t t_us) {
  const double t = static_cast<double>(t_us) * 1e-6;
  PoseSample pose;
  pose.t_us = t_us;
  pose.position_m[0] = 0.5 * t;
  pose.position_m[2] = 1;
  pose.orientation_xyzw[2] = std::sin(0.2 * t);
  pose.orientation_xyzw[3] = std::cos(0.2 * t);
  return pose;
}

MotionConfig pose_config() {
  MotionConfig config;
  config.source = MotionSource::kPoses;
  return config;
}

void add_slide(EgoMotion& ego, std::int64_t from_us, std::int64_t to_us) {
  for (std::int64_t t = from_us; t <= to_us; t += 10000) {
    PoseSample pose = slide_pose(t);
    if ((t / 10000) % 2) {  // q and -q are the same pose
      for (double& q : pose.orientation_xyzw) q = -q;
    }
    ego.add(pose);
  }
}

}  // namespace

TEST_CASE("the order of arrival does not matter before advance()") {
  Drive drive = car_drive();
  drive.duration_s = 6;
  const auto straight = std::make_unique<EgoMotion>(config_of(drive));
  const auto shuffled = std::make_unique<EgoMotion>(config_of(drive));
  std::vector<std::variant<ImuSample, OdometrySample>> waiting;
  Random random(7);
  simulate(
      drive,
      [&](const auto& sample) {
        straight->add(sample);
        waiting.insert(waiting.begin() + static_cast<int>(random.bits() % (waiting.size() + 1)), sample);
      },
      [&](const RobotSimulator& robot) {
        for (const auto& sample : waiting) std::visit([&](const auto& s) { shuffled->add(s); }, sample);
        waiting.clear();
        straight->advance(robot.t_us());
        shuffled->advance(robot.t_us());
        REQUIRE(same(straight->at_end(robot.t_us()), shuffled->at_end(robot.t_us())));
      });
  CHECK(straight->imu_counters().used == 1200);
  CHECK(shuffled->imu_counters().used == 1200);
  CHECK(shuffled->imu_counters().late == 0);
}

TEST_CASE("late samples are dropped and counted") {
  const auto ego = std::make_unique<EgoMotion>(MotionConfig{});
  ego->advance(1000);
  ImuSample imu;
  imu.has_gyro = true;
  for (std::int64_t t : {999, 1000, 1001}) {
    imu.t_us = t;
    ego->add(imu);
  }
  OdometrySample odometry;
  odometry.t_us = 1000;
  ego->add(odometry);
  CHECK(ego->imu_counters().late == 2);
  CHECK(ego->odometry_counters().late == 1);
  ego->advance(2000);
  CHECK(ego->imu_counters().in == 3);
  CHECK(ego->imu_counters().used == 1);
  CHECK(ego->earliest_us() == INT64_MAX);  // no odometry: no motion
  CHECK(ego->newest_us() == INT64_MIN);
}

TEST_CASE("what is not finite or not plausible is dropped and counted, and changes nothing") {
  Drive drive = car_drive();
  drive.duration_s = 5;
  const auto clean = std::make_unique<EgoMotion>(config_of(drive));
  const auto dirty = std::make_unique<EgoMotion>(config_of(drive));
  std::uint64_t bad_imu = 0;
  std::uint64_t bad_odometry = 0;
  const auto spoil_imu = [&](double gyro, double accel, std::int64_t t_us) {
    ImuSample sample;
    sample.t_us = t_us;
    sample.has_gyro = true;
    sample.has_accel = true;
    sample.gyro_rad_s[1] = gyro;
    sample.accel_m_s2[2] = accel;
    dirty->add(sample);
    ++bad_imu;
  };
  const auto spoil_odometry = [&](double speed, double variance, OdometrySample::Kind kind,
                                  std::int64_t t_us) {
    OdometrySample sample;
    sample.t_us = t_us;
    sample.kind = kind;
    sample.velocity_m_s[0] = speed;
    sample.covariance_m2_s2[0] = variance;
    dirty->add(sample);
    ++bad_odometry;
  };
  simulate(
      drive,
      [&](const auto& sample) {
        clean->add(sample);
        dirty->add(sample);
        spoil_imu(kNan, 9.8, sample.t_us);
        spoil_imu(0, std::numeric_limits<double>::infinity(), sample.t_us);
        spoil_imu(41, 9.8, sample.t_us);
        spoil_imu(0, 9.8, INT64_MAX);
        spoil_odometry(kNan, 0, OdometrySample::Kind::kWheelSpeed, sample.t_us);
        spoil_odometry(61, 0, OdometrySample::Kind::kWheelSpeed, sample.t_us);
        spoil_odometry(1, kNan, OdometrySample::Kind::kWheelSpeed, sample.t_us);
        spoil_odometry(1, -1, OdometrySample::Kind::kWheelSpeed, sample.t_us);
        spoil_odometry(1, 0.1, OdometrySample::Kind::kBodyVelocity, sample.t_us);  // a singular covariance
        spoil_odometry(1, 0, OdometrySample::Kind::kWheelSpeed, INT64_MIN);
      },
      [&](const RobotSimulator& robot) {
        clean->advance(robot.t_us());
        dirty->advance(robot.t_us());
        REQUIRE(same(clean->at_end(robot.t_us()), dirty->at_end(robot.t_us())));
      });
  CHECK(dirty->imu_counters().invalid == bad_imu);
  CHECK(dirty->odometry_counters().invalid == bad_odometry);
  CHECK(dirty->imu_counters().used == clean->imu_counters().used);
}

TEST_CASE("every third IMU sample and every second of the wheels missing") {
  Drive drive = car_drive();
  drive.duration_s = 20;
  const auto ego = std::make_unique<EgoMotion>(config_of(drive));
  int n = 0;
  double worst = 0;
  simulate(
      drive,
      [&](const auto& sample) {
        if (++n % 3 != 0) ego->add(sample);
      },
      [&](const RobotSimulator& robot) {
        ego->advance(robot.t_us());
        const double v = robot.velocity().v[0];
        if (v > 3) worst = std::max(worst, std::abs(ego->filter().velocity_m_s()[0] - v) / v);
      });
  WARN("a third of all samples missing: worst velocity error " << 100 * worst << " %");
  CHECK(worst < 0.03);
}

TEST_CASE("a wheel that spins is rejected; a new truth is accepted after a second") {
  Drive drive = car_drive();
  drive.duration_s = 14;
  const auto ego = std::make_unique<EgoMotion>(config_of(drive));
  double error_while_spinning = 1e9;
  const auto feed = [&](auto sample) {
    if constexpr (std::is_same_v<decltype(sample), OdometrySample>) {
      if (sample.t_us > 12000000) sample.velocity_m_s[0] += 8;
    }
    ego->add(sample);
  };
  simulate(drive, feed, [&](const RobotSimulator& robot) {
    ego->advance(robot.t_us());
    if (robot.t_us() == 12800000) {
      error_while_spinning = std::abs(ego->filter().velocity_m_s()[0] - robot.velocity().v[0]);
    }
  });
  CHECK(error_while_spinning < 0.36);
  const std::uint64_t rejected = ego->odometry_counters().rejected;
  CHECK(rejected >= 50);
  CHECK(rejected <= 60);
  CHECK(ego->filter().velocity_m_s()[0] > 19);  // whoever says so for long is believed
}

TEST_CASE("the lever arm: a camera ahead of a turning body moves sideways") {
  Drive drive{{[](double) {
                 return Triple{{2, 0, 0}};
               },
               [](double t) {
                 return Triple{{0, 0, 0.5 * ramp(t, 1, 2)}};
               }},
              SensorFaults{}};
  drive.faults.wheel_scale = 0;
  drive.duration_s = 5;
  MotionConfig config = config_of(drive);
  config.camera_in_body_m[0] = 1.5;
  const auto ego = std::make_unique<EgoMotion>(config);
  simulate(
      drive, [&](const auto& sample) { ego->add(sample); },
      [&](const RobotSimulator& robot) { ego->advance(robot.t_us()); });
  const CameraMotion motion = ego->at_end(5000000);
  CHECK(std::abs(motion.velocity_m_s[2] - 2) < 0.06);          // forward
  CHECK(std::abs(motion.velocity_m_s[0] + 0.75) < 0.06);       // left is -x
  CHECK(std::abs(motion.angular_rate_rad_s[1] + 0.5) < 0.03);  // left turn: about -y
  CHECK(speed_sigma_m_s(motion) > 0.005);
  CHECK(speed_sigma_m_s(motion) < 0.08);

  std::vector<MotionSample> window(32);
  CHECK(ego->samples(4800000, 5000000, window) == 20);
  CHECK(window[0].t_us == 4800000);
  CHECK(window[19].t_us == 5000000);
  CHECK(ego->samples(0, 5000000, window) == 0);
}

TEST_CASE("motion ends when samples do") {
  Drive drive = car_drive();
  drive.duration_s = 3;
  const auto ego = std::make_unique<EgoMotion>(config_of(drive));
  simulate(
      drive, [&](const auto& sample) { ego->add(sample); },
      [&](const RobotSimulator& robot) { ego->advance(robot.t_us()); });
  const auto track = std::make_unique<MotionTrack>();
  CHECK(ego->newest_us() == 3000000);
  CHECK(ego->track(2900000, 3000000, *track));
  CHECK(ego->track(2900000, 3900000, *track));
  CHECK_FALSE(ego->track(2900000, 4100000, *track));
  CHECK_FALSE(ego->track(0, 3000000, *track));
}

TEST_CASE("more samples than may wait are used early, none is lost") {
  const auto ego = std::make_unique<EgoMotion>(MotionConfig{});
  ImuSample imu;
  imu.has_gyro = true;
  for (int i = 0; i < 5000; ++i) {
    imu.t_us = i * 1000;
    ego->add(imu);
  }
  ego->advance(10000000);
  CHECK(ego->imu_counters().used == 5000);
  CHECK(ego->imu_counters().late == 0);
}

TEST_CASE("settings that cannot be meant are refused by name") {
  CHECK(EgoMotion::check(MotionConfig{}).ok());
  MotionConfig config;
  config.camera_from_body[0] = 0.1;
  CHECK(std::string(EgoMotion::check(config).subject()) == "camera_from_body");
  config = {};
  for (int i = 0; i < 3; ++i) config.camera_from_body[i] *= -1;  // a mirror
  CHECK_FALSE(EgoMotion::check(config).ok());
  config = {};
  config.gyro_noise_rad_s = 0;
  CHECK(EgoMotion::check(config).code() == StatusCode::kBadMotion);
  config = {};
  config.wheel_noise_m_s = kNan;
  CHECK_FALSE(EgoMotion::check(config).ok());
}

TEST_CASE("poses: the track of an analytic motion") {
  const auto ego = std::make_unique<EgoMotion>(pose_config());
  add_slide(*ego, 1000000, 1200000);
  ego->advance(1205000);
  CHECK(ego->earliest_us() == 1000000);
  CHECK(ego->newest_us() == 1200000);
  const auto track = std::make_unique<MotionTrack>();
  REQUIRE(ego->track(1000000, 1205000, *track));  // 5 ms beyond the last pose
  double worst_m = 0;
  double worst_rad = 0;
  const double end = 1.205;
  for (int i = 0; i < MotionTrack::kKnots; ++i) {
    const double t = 1 + 0.205 * i / 127;
    // World to end: turn by -0.4 end about z. The camera at t was 0.5 (end - t) behind along the world's x.
    const double back = -0.5 * (end - t);
    const double cx = std::cos(0.4 * end) * back;
    const double cy = -std::sin(0.4 * end) * back;
    const MotionKnot& knot = track->knots[i];
    worst_m = std::max({worst_m, std::abs(knot.centre_m[0] - cx), std::abs(knot.centre_m[1] - cy),
                        std::abs(knot.centre_m[2])});
    worst_rad =
        std::max({worst_rad, std::abs(knot.rotation[0] - std::cos(0.4 * (end - t))),
                  std::abs(knot.rotation[1] - std::sin(0.4 * (end - t))), std::abs(knot.rotation[8] - 1)});
  }
  WARN("poses: worst error " << worst_m << " m, " << worst_rad << " rad");
  CHECK(worst_m < 1e-9);
  CHECK(worst_rad < 1e-9);
  const CameraMotion motion = ego->at_end(1205000);
  CHECK(motion.velocity_m_s[0] == Approx(0.5 * std::cos(0.4 * end)));
  CHECK(motion.velocity_m_s[1] == Approx(-0.5 * std::sin(0.4 * end)));
  CHECK(motion.angular_rate_rad_s[2] == Approx(0.4));
}

TEST_CASE("poses: no track before the first, across a gap, or across a jump") {
  const auto ego = std::make_unique<EgoMotion>(pose_config());
  const auto track = std::make_unique<MotionTrack>();
  ego->add(slide_pose(1000000));
  ego->advance(1000000);
  CHECK(ego->earliest_us() == INT64_MAX);  // one pose is no motion
  CHECK_FALSE(ego->track(1000000, 1000000, *track));
  add_slide(*ego, 1010000, 1200000);
  add_slide(*ego, 1310000, 1500000);  // 110 ms of nothing
  ego->advance(1500000);
  CHECK(ego->track(1000000, 1200000, *track));
  CHECK_FALSE(ego->track(999999, 1200000, *track));
  CHECK_FALSE(ego->track(1100000, 1400000, *track));
  CHECK_FALSE(ego->track(1250000, 1260000, *track));
  CHECK(ego->track(1310000, 1500000, *track));
  CHECK(ego->pose_counters().rejected == 0);

  PoseSample jump = slide_pose(1510000);
  jump.position_m[1] = 3;
  ego->add(jump);
  PoseSample after = slide_pose(1520000);
  after.position_m[1] = 3;
  ego->add(after);
  after.t_us = 1530000;
  after.orientation_xyzw[3] = 0;  // no unit quaternion
  after.orientation_xyzw[2] = 0.5;
  ego->add(after);
  ego->advance(1530000);
  CHECK(ego->pose_counters().rejected == 1);
  CHECK(ego->pose_counters().invalid == 1);
  CHECK_FALSE(ego->track(1490000, 1520000, *track));
  CHECK(ego->track(1510000, 1520000, *track));
}
