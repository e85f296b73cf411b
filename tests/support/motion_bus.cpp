#include "support/motion_bus.hpp"

#include <array>

#include "citysim/random.hpp"
#include "recording/number_text.hpp"

namespace egofocus::sim {
namespace {

constexpr double kGravity = 9.80665;
constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kGyroUnit = 0.01 * kDegree;  // rad/s per bit; the factors of vehicle_dbc()
constexpr double kAccelUnit = 0.002;
constexpr double kVelocityUnit = 0.001;
constexpr std::int64_t kImuPeriodUs = 5000;
constexpr std::int64_t kVelocityPeriodUs = 20000;

using Bytes = std::array<std::uint8_t, 8>;

std::uint16_t word(double value, double unit) {
  const double raw = floor_of(value / unit + 0.5);
  const double limited = raw < -32768 ? -32768 : (raw > 32767 ? 32767 : raw);
  return static_cast<std::uint16_t>(static_cast<std::int32_t>(limited) & 0xffff);
}

void put_intel(Bytes& bytes, std::size_t at, std::uint16_t value) {
  bytes[at] = static_cast<std::uint8_t>(value & 0xff);
  bytes[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

void put_motorola(Bytes& bytes, std::size_t at, std::uint16_t value) {
  bytes[at] = static_cast<std::uint8_t>(value >> 8);
  bytes[at + 1] = static_cast<std::uint8_t>(value & 0xff);
}

void add_line(std::string& log, std::int64_t t_us, const char* id, const Bytes& bytes) {
  static constexpr char kDigits[] = "0123456789ABCDEF";
  log += "(" + recording::seconds_text(t_us) + ") can0 " + id + "#";
  for (const std::uint8_t byte : bytes) {
    log += kDigits[byte >> 4];
    log += kDigits[byte & 15];
  }
  log += "\n";
}

Mat3 matrix(const double (&m)[9]) {
  return {{{m[0], m[1], m[2]}, {m[3], m[4], m[5]}, {m[6], m[7], m[8]}}};
}

Vec3 noisy(const Vec3& value, const Vec3& bias, double sigma, Random& random) {
  Vec3 out = value + bias;
  for (double& component : out) component += sigma * random.normal();
  return out;
}

/// What an accelerometer at the body origin feels: acceleration minus gravity, in the body frame.
Vec3 specific_force(const Trajectory& path, const MotionConfig& extrinsics, std::int64_t t_us) {
  constexpr std::int64_t kHalfUs = 250;
  const BodyTwist now = body_twist(path.twist_at(t_us), extrinsics);
  const BodyTwist before = body_twist(path.twist_at(t_us - kHalfUs), extrinsics);
  const BodyTwist after = body_twist(path.twist_at(t_us + kHalfUs), extrinsics);
  const Vec3 change = (1e6 / (2.0 * kHalfUs)) * (after.velocity_m_s - before.velocity_m_s);
  const Mat3 world_from_body = path.pose_at(t_us).rotation * matrix(extrinsics.camera_from_body);
  const Vec3 up = transpose(world_from_body) * Vec3{0, 0, 1};
  return change + cross(now.rate_rad_s, now.velocity_m_s) + kGravity * up;
}

}  // namespace

BodyTwist body_twist(const Twist& camera, const MotionConfig& extrinsics) {
  const Mat3 body_from_camera = transpose(matrix(extrinsics.camera_from_body));
  const Vec3 lever{extrinsics.camera_in_body_m[0], extrinsics.camera_in_body_m[1],
                   extrinsics.camera_in_body_m[2]};
  const Vec3 rate = body_from_camera * camera.rate_rad_s;
  return {body_from_camera * camera.velocity_m_s - cross(rate, lever), rate};
}

std::string vehicle_dbc() {
  return R"(VERSION "1"

NS_ :

BS_:

BU_: IMU DVL ECU

BO_ 372 IMU_RATE: 8 IMU
 SG_ GyroX : 0|16@1- (0.01,0) [-327|327] "deg/s" ECU
 SG_ GyroY : 16|16@1- (0.01,0) [-327|327] "deg/s" ECU
 SG_ GyroZ : 32|16@1- (0.01,0) [-327|327] "deg/s" ECU
 SG_ RateCounter : 48|8@1+ (1,0) [0|255] "" ECU

BO_ 376 IMU_FORCE: 8 IMU
 SG_ AccelX : 7|16@0- (0.002,0) [-65|65] "m/s2" ECU
 SG_ AccelY : 23|16@0- (0.002,0) [-65|65] "m/s2" ECU
 SG_ AccelZ : 39|16@0- (0.002,0) [-65|65] "m/s2" ECU
 SG_ ForceCounter : 55|8@0+ (1,0) [0|255] "" ECU

BO_ 2566852864 BODY_MOTION: 8 DVL
 SG_ Page M : 0|8@1+ (1,0) [0|1] "" ECU
 SG_ VelX m0 : 8|16@1- (0.001,0) [-32|32] "m/s" ECU
 SG_ VelY m0 : 24|16@1- (0.001,0) [-32|32] "m/s" ECU
 SG_ VelZ m0 : 40|16@1- (0.001,0) [-32|32] "m/s" ECU
 SG_ Altitude m1 : 15|16@0+ (0.01,0) [0|655] "m" ECU

CM_ BO_ 372 "Angular rate, Intel order";
CM_ BO_ 376 "Specific force, Motorola order";
CM_ BO_ 2566852864 "29-bit id; page 0 velocity, page 1 altitude";
)";
}

std::string can_log(const Trajectory& trajectory, const MotionConfig& extrinsics, const MotionFaults& faults,
                    std::uint64_t seed) {
  Random random(seed);
  std::string log;
  std::uint8_t counter = 0;
  for (std::int64_t t = 0; t <= trajectory.duration_us(); t += kImuPeriodUs, ++counter) {
    const BodyTwist body = body_twist(trajectory.twist_at(t), extrinsics);
    const Vec3 gyro = noisy(body.rate_rad_s, faults.gyro_bias_rad_s, faults.gyro_noise_rad_s, random);
    const Vec3 force = noisy(specific_force(trajectory, extrinsics, t), faults.accel_bias_m_s2,
                             faults.accel_noise_m_s2, random);
    Bytes rate_frame{};
    Bytes force_frame{};
    for (std::size_t i = 0; i < 3; ++i) put_intel(rate_frame, 2 * i, word(gyro[i], kGyroUnit));
    for (std::size_t i = 0; i < 3; ++i) put_motorola(force_frame, 2 * i, word(force[i], kAccelUnit));
    rate_frame[6] = force_frame[6] = counter;
    add_line(log, t, "174", rate_frame);
    add_line(log, t + 120, "178", force_frame);
    if (t % kVelocityPeriodUs != 0) continue;
    const Vec3 velocity = noisy(body.velocity_m_s, {0, 0, 0}, faults.velocity_noise_m_s, random);
    Bytes velocity_page{};
    for (std::size_t i = 0; i < 3; ++i) put_intel(velocity_page, 1 + 2 * i, word(velocity[i], kVelocityUnit));
    add_line(log, t + 260, "18FF1100", velocity_page);
    Bytes altitude_page{1};
    put_motorola(altitude_page, 1, word(1.25, 0.01));
    add_line(log, t + 390, "18FF1100", altitude_page);
  }
  return log;
}

}  // namespace egofocus::sim
