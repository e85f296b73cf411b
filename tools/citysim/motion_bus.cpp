#include "citysim/motion_bus.hpp"

#include <algorithm>
#include <stdexcept>

#include "citysim/bus_layout.hpp"
#include "citysim/can_bus.hpp"
#include "citysim/random.hpp"

namespace egofocus::citysim {
namespace {

using sim::Random;

constexpr double kGravity_m_s2 = 9.80665;
constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr std::int64_t kBetweenFrames_us = 20;  // of one sample, as its sensor hands them to the controller

Vec3 random_vector(Random& random, double sigma) {
  const double x = random.normal();
  const double y = random.normal();
  const double z = random.normal();
  return {sigma * x, sigma * y, sigma * z};
}

double seconds(std::int64_t t_us) {
  return static_cast<double>(t_us) * 1e-6;
}
std::int64_t microseconds(double t_s) {
  return static_cast<std::int64_t>(t_s * 1e6 + 0.5);
}

/// Silences of the odometry.
std::vector<std::pair<std::int64_t, std::int64_t>> draw_dropouts(const BusFaults& faults, std::int64_t end_us,
                                                                 Random random) {
  std::vector<std::pair<std::int64_t, std::int64_t>> dropouts;
  if (!(faults.dropout_every_s > 0)) return dropouts;
  for (std::int64_t t_us = 0;;) {
    t_us += microseconds(-faults.dropout_every_s * sim::natural_log(1.0 - random.uniform()));
    if (t_us >= end_us) return dropouts;
    const std::int64_t until_us = t_us + microseconds(random.uniform(0.1, 1.0));
    dropouts.emplace_back(t_us, until_us);
    t_us = until_us;
  }
}

/// All senders; frames carry the time from which they want the bus.
class Senders {
 public:
  Senders(const Trajectory& trajectory, BusRobot robot, const BusFaults& faults, const BusLayout& layout,
          MotionBus& out)
      : trajectory_(trajectory),
        robot_(robot),
        faults_(faults),
        layout_(layout),
        end_us_(microseconds(trajectory.duration_s())),
        out_(out) {}

  void imu(Random random) {
    Vec3 bias = faults_.gyro_bias_rad_s;
    const double walk = faults_.gyro_bias_walk_rad_s2 * square_root(seconds(layout_.imu_period_us));
    const std::int64_t first_us = phase(layout_.imu_period_us, random);
    std::uint32_t count = random.below(65536);
    for (std::int64_t t_us = first_us; t_us <= end_us_; t_us += layout_.imu_period_us) {
      const RigidState body = trajectory_.body_at(seconds(t_us));
      const Vec3 up = sim::transpose(body.pose.rotation) * Vec3{0, 0, 1};
      bias = bias + random_vector(random, walk);
      ImuReading reading;
      reading.t_us = t_us;
      reading.rate_rad_s =
          (1 + faults_.gyro_scale) * body.rate_rad_s + bias + random_vector(random, faults_.gyro_noise_rad_s);
      reading.force_m_s2 = body.acceleration_m_s2 + kGravity_m_s2 * up + faults_.accel_bias_m_s2 +
                           random_vector(random, faults_.accel_noise_m_s2);
      std::int64_t ready_us = t_us + faults_.imu_latency_us + jitter(random);
      for (const CanFrame& frame : imu_frames(robot_, reading, count)) {
        send(frame, ready_us, random);
        ready_us += kBetweenFrames_us;
      }
      ++count;
    }
  }

  void odometry(Random random) {
    const Vec3 wheel_scale = random_vector(random, faults_.wheel_scale_spread);
    std::uint32_t count = 0;
    for (std::int64_t t_us = phase(layout_.odometry_period_us, random); t_us <= end_us_;
         t_us += layout_.odometry_period_us) {
      const RigidState body = trajectory_.body_at(seconds(t_us));
      const CanFrame frame =
          layout_.wheels ? wheels(body, wheel_scale, random) : velocity(body, count, random);
      ++count;
      const std::int64_t ready_us = t_us + faults_.odometry_latency_us + jitter(random);
      if (!silent(t_us)) send(frame, ready_us, random);
    }
  }

  void others(Random random) {
    for (const OtherMessage& other : layout_.others) {
      CanFrame frame;
      frame.id = other.id;
      frame.extended = other.extended;
      frame.length = static_cast<std::uint8_t>(other.length);
      for (std::int64_t t_us = phase(other.period_us, random); t_us <= end_us_; t_us += other.period_us) {
        const std::uint64_t bits = random.bits();
        for (std::size_t i = 0; i < frame.length; ++i)
          frame.data[i] = static_cast<std::uint8_t>(bits >> (8 * i) & 0xff);
        frame.t_us = t_us + jitter(random);
        ready_.push_back(frame);
      }
    }
  }

  [[nodiscard]] std::vector<CanFrame> take() { return std::move(ready_); }

 private:
  static std::int64_t phase(std::int64_t period_us, Random& random) {
    return static_cast<std::int64_t>(random.below(static_cast<std::uint32_t>(period_us)));
  }
  std::int64_t jitter(Random& random) const {
    return static_cast<std::int64_t>(random.below(static_cast<std::uint32_t>(faults_.jitter_us) + 1));
  }

  [[nodiscard]] bool silent(std::int64_t t_us) const {
    return std::any_of(out_.dropouts_us.begin(), out_.dropouts_us.end(),
                       [&](const auto& dropout) { return t_us >= dropout.first && t_us < dropout.second; });
  }

  void send(CanFrame frame, std::int64_t ready_us, Random& random) {
    if (random.chance(faults_.lost_frame_share)) {
      ++out_.lost_frames;
      return;
    }
    frame.t_us = ready_us;
    ready_.push_back(frame);
    ++out_.motion_frames;
  }

  /// Rolling without slip: rear wheels along the body's x; front wheels as they are steered.
  CanFrame wheels(const RigidState& body, const Vec3& scale, Random& random) const {
    const double forward = body.velocity_m_s[0];
    const double aside = 0.5 * layout_.track_m * body.rate_rad_s[2];
    const double front_left = layout_.wheelbase_m * body.rate_rad_s[2];
    const auto pulses = [&](double speed, double along_left, double own_scale) {
      const double rolled = square_root(speed * speed + along_left * along_left);
      const double whole = (1 + faults_.odometry_scale) * (1 + own_scale) * rolled;
      const double noisy = rolled > 0 ? whole + faults_.odometry_noise_m_s * random.normal() : 0;
      const bool counted = whole >= faults_.odometry_zero_below_m_s;
      return counted ? (speed < 0 ? -noisy : noisy) : 0.0;
    };
    WheelReading reading;
    reading.front_left_m_s = pulses(forward - aside, front_left, 0);
    reading.front_right_m_s = pulses(forward + aside, front_left, scale[2]);
    reading.rear_left_m_s = pulses(forward - aside, 0, scale[0]);
    reading.rear_right_m_s = pulses(forward + aside, 0, scale[1]);
    return wheel_frame(robot_, reading);
  }

  CanFrame velocity(const RigidState& body, std::uint32_t count, Random& random) const {
    const Vec3 noisy =
        (1 + faults_.odometry_scale) * body.velocity_m_s + random_vector(random, faults_.odometry_noise_m_s);
    return velocity_frame(robot_, noisy, count);
  }

  const Trajectory& trajectory_;
  BusRobot robot_;
  const BusFaults& faults_;
  const BusLayout& layout_;
  std::int64_t end_us_;
  MotionBus& out_;
  std::vector<CanFrame> ready_;
};

void set_extrinsics(const Mount& camera, MotionConfig& motion) {
  const sim::Mat3 camera_from_body = sim::transpose(camera.rotation);
  for (std::size_t i = 0; i < 3; ++i) {
    motion.camera_in_body_m[i] = camera.position[i];
    for (std::size_t j = 0; j < 3; ++j) motion.camera_from_body[3 * i + j] = camera_from_body[i][j];
  }
}

/// As a user measures them at rest, a third on top; never below what quantisation leaves.
void state_noises(const BusFaults& faults, MotionConfig& motion) {
  motion.gyro_noise_rad_s = std::max(0.0015, 1.3 * faults.gyro_noise_rad_s);
  motion.accel_noise_m_s2 = std::max(0.03, 1.3 * faults.accel_noise_m_s2);
}

}  // namespace

BusFaults draw_bus_faults(BusRobot robot, std::uint64_t seed) {
  Random random(seed, "bus faults");
  BusFaults faults;
  for (double& bias : faults.gyro_bias_rad_s) bias = random.uniform(-1, 1) * kDegree;
  faults.gyro_bias_walk_rad_s2 = random.log_uniform(1e-5, 1e-4);
  faults.gyro_scale = random.uniform(-0.003, 0.003);
  faults.gyro_noise_rad_s = random.log_uniform(0.02, 0.12) * kDegree;
  for (double& bias : faults.accel_bias_m_s2) bias = random.uniform(-0.06, 0.06);
  faults.accel_noise_m_s2 = random.log_uniform(0.01, 0.08);
  faults.imu_latency_us = random.below(8000) + 800;
  faults.odometry_latency_us = random.below(8000) + 1000;
  faults.jitter_us = random.below(600) + 50;
  faults.dropout_every_s = random.uniform(15, 40);
  faults.lost_frame_share = random.log_uniform(1e-5, 1e-3);
  faults.wheel_scale_spread = 0.001;
  const double size = random.uniform();
  const double sign = random.chance(0.5) ? 1 : -1;
  switch (robot) {
    case BusRobot::kCar:
      faults.odometry_scale = 0.02 * size * sign;
      faults.odometry_noise_m_s = random.uniform(0.005, 0.02);
      faults.odometry_zero_below_m_s = 1.5 / 3.6;
      break;
    case BusRobot::kDeliveryRobot:
      faults.odometry_scale = 0.02 * size * sign;
      faults.odometry_noise_m_s = random.uniform(0.003, 0.01);
      break;
    case BusRobot::kDrone:
      faults.odometry_scale = 0.005 * size * sign;
      faults.odometry_noise_m_s = random.uniform(0.01, 0.03);
      break;
    case BusRobot::kHand:
      faults.odometry_scale = 0.01 * size * sign;
      faults.odometry_noise_m_s = random.uniform(0.003, 0.01);
      break;
    case BusRobot::kArm:
      faults.odometry_scale = 0.003 * size * sign;
      faults.odometry_noise_m_s = random.uniform(0.0005, 0.002);
      break;
  }
  return faults;
}

MotionBus motion_bus(const Trajectory& trajectory, BusRobot robot, const BusFaults& faults,
                     const Mount& camera, std::uint64_t seed) {
  if (faults.imu_latency_us < 0 || faults.odometry_latency_us < 0 || faults.jitter_us < 0)
    throw std::invalid_argument("a bus latency or jitter is negative");
  const BusLayout layout = bus_layout(robot);
  MotionBus bus;
  bus.faults = faults;
  bus.dbc = layout.dbc;
  bus.can = layout.can;
  bus.motion = layout.motion;
  set_extrinsics(camera, bus.motion);
  state_noises(faults, bus.motion);
  const std::int64_t end_us = microseconds(trajectory.duration_s());
  bus.dropouts_us = draw_dropouts(faults, end_us, Random(seed, "dropouts"));

  // Stated as a bench would measure it: from the motion to the end of the frame that is stamped.
  const std::int64_t half_jitter_us = faults.jitter_us / 2;
  bus.can.imu_delay_us = faults.imu_latency_us + half_jitter_us;
  const std::vector<CanFrame> sample = imu_frames(robot, {}, 0);
  for (std::size_t i = 0; i <= layout.gyro_frame; ++i)
    bus.can.imu_delay_us += frame_time_us(sample[i], layout.bits_per_s);
  bus.can.odometry_delay_us =
      faults.odometry_latency_us + half_jitter_us + frame_time_us(wheel_frame(robot, {}), layout.bits_per_s);

  Senders senders(trajectory, robot, faults, layout, bus);
  senders.imu(Random(seed, "inertial sensor"));
  senders.odometry(Random(seed, "odometry"));
  senders.others(Random(seed, "other traffic"));
  std::int64_t busy_us = 0;
  bus.frames = arbitrated(senders.take(), layout.bits_per_s, busy_us);
  bus.load = static_cast<double>(busy_us) / static_cast<double>(end_us);
  return bus;
}

}  // namespace egofocus::citysim
