// Sources: the sensors' manuals as far as they are public; each layout is repeated in bus_layout.cpp's DBC,
// which is what a reader goes by.
#include "citysim/bus_layout.hpp"
#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kStandardGravity_m_s2 = 9.80665;

CanFrame frame_of(std::uint32_t id, int length, bool extended = false) {
  CanFrame frame;
  frame.id = id;
  frame.extended = extended;
  frame.length = static_cast<std::uint8_t>(length);
  return frame;
}

/// The nearest of the values that 16 bits can say.
std::uint16_t word(double value, double factor, double offset, double lowest, double highest) {
  const double raw = floor_of((value - offset) / factor + 0.5);
  const double limited = raw < lowest ? lowest : raw > highest ? highest : raw;
  return static_cast<std::uint16_t>(static_cast<std::int32_t>(limited) & 0xffff);
}
std::uint16_t unsigned_word(double value, double factor, double offset, double highest = 65535) {
  return word(value, factor, offset, 0, highest);
}
std::uint16_t signed_word(double value, double factor) {
  return word(value, factor, 0, -32768, 32767);
}

void put_intel(CanFrame& frame, std::size_t byte, std::uint16_t value) {
  frame.data[byte] = static_cast<std::uint8_t>(value & 0xff);
  frame.data[byte + 1] = static_cast<std::uint8_t>(value >> 8);
}
void put_motorola(CanFrame& frame, std::size_t byte, std::uint16_t value) {
  frame.data[byte] = static_cast<std::uint8_t>(value >> 8);
  frame.data[byte + 1] = static_cast<std::uint8_t>(value & 0xff);
}

/// One frame of a Bosch MM7.10: a rate at byte 0, an acceleration at byte 4, a counter in byte 6.
CanFrame bosch_frame(std::uint32_t id, double rate_rad_s, double force_m_s2, std::uint32_t count) {
  CanFrame frame = frame_of(id, 8);
  put_intel(frame, 0, unsigned_word(rate_rad_s / kDegree, 0.005, -163.84));
  put_intel(frame, 4, unsigned_word(force_m_s2 / kStandardGravity_m_s2, 0.000127465, -4.1768));
  frame.data[6] = static_cast<std::uint8_t>(count & 15);
  return frame;
}

/// Three little-endian words of a J1939 inertial sensor, then figures of merit (good) and the latency.
CanFrame j1939_frame(std::uint32_t id, const Vec3& value, double factor, double offset) {
  constexpr double kLargestValid = 0xFAFF;
  CanFrame frame = frame_of(id, 8, true);
  for (std::size_t i = 0; i < 3; ++i)
    put_intel(frame, 2 * i, unsigned_word(value[i], factor, offset, kLargestValid));
  frame.data[6] = 0;
  frame.data[7] = 10;  // 5 ms
  return frame;
}

CanFrame xsens_frame(std::uint32_t id, const Vec3& value, double factor) {
  CanFrame frame = frame_of(id, 6);
  for (std::size_t i = 0; i < 3; ++i) put_motorola(frame, 2 * i, signed_word(value[i], factor));
  return frame;
}

std::vector<CanFrame> xsens_sample(const ImuReading& reading, std::uint32_t count) {
  CanFrame time = frame_of(0x005, 4);
  const auto t_us = static_cast<std::uint32_t>(reading.t_us);
  put_motorola(time, 0, static_cast<std::uint16_t>(t_us >> 16));
  put_motorola(time, 2, static_cast<std::uint16_t>(t_us & 0xffff));
  CanFrame counter = frame_of(0x006, 2);
  put_motorola(counter, 0, static_cast<std::uint16_t>(count & 0xffff));
  return {time, counter, xsens_frame(0x032, reading.rate_rad_s, 1.0 / 512),
          xsens_frame(0x034, reading.force_m_s2, 1.0 / 256)};
}

}  // namespace

std::vector<CanFrame> imu_frames(BusRobot robot, const ImuReading& reading, std::uint32_t count) {
  const Vec3& rate = reading.rate_rad_s;
  const Vec3& force = reading.force_m_s2;
  switch (robot) {
    case BusRobot::kCar:
      return {bosch_frame(0x174, rate[2], force[1], count), bosch_frame(0x178, -rate[0], force[0], count),
              bosch_frame(0x17C, rate[1], force[2], count)};
    case BusRobot::kDeliveryRobot: {
      const Vec3 down_rate_deg_s{rate[0] / kDegree, -rate[1] / kDegree, -rate[2] / kDegree};
      const Vec3 down_force{force[0], -force[1], -force[2]};
      return {j1939_frame(0x08F02A80, down_rate_deg_s, 1.0 / 128, -250),
              j1939_frame(0x08F02D80, down_force, 0.01, -320)};
    }
    case BusRobot::kDrone:
    case BusRobot::kHand:
    case BusRobot::kArm:
      break;
  }
  return xsens_sample(reading, count);
}

CanFrame wheel_frame(BusRobot robot, const WheelReading& reading) {
  constexpr double kKmPerHour = 3.6;
  if (robot == BusRobot::kCar) {
    CanFrame frame = frame_of(0x0AA, 8);
    const double order[4] = {reading.front_right_m_s, reading.front_left_m_s, reading.rear_right_m_s,
                             reading.rear_left_m_s};
    for (std::size_t i = 0; i < 4; ++i)
      put_motorola(frame, 2 * i, unsigned_word(kKmPerHour * order[i], 0.01, -67.67));
    return frame;
  }
  CanFrame frame = frame_of(0x0CE, 8);
  const double order[4] = {reading.front_left_m_s, reading.front_right_m_s, reading.rear_left_m_s,
                           reading.rear_right_m_s};
  for (std::size_t i = 0; i < 4; ++i) put_intel(frame, 2 * i, signed_word(kKmPerHour * order[i], 0.0625));
  return frame;
}

CanFrame velocity_frame(BusRobot robot, const Vec3& velocity_m_s, std::uint32_t count) {
  if (robot == BusRobot::kDrone) return xsens_frame(0x076, velocity_m_s, 1.0 / 64);
  CanFrame frame = frame_of(0x2A0, 8);
  for (std::size_t i = 0; i < 3; ++i) put_intel(frame, 2 * i, signed_word(velocity_m_s[i], 0.001));
  frame.data[6] = static_cast<std::uint8_t>(count & 0xff);
  frame.data[7] = 1;  // tracking
  return frame;
}

}  // namespace egofocus::citysim
