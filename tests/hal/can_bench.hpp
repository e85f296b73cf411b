// Small words for tests of the CAN motion decoder: roles, frames, and a decoder that keeps what it gave.
#pragma once

#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "hal/can_motion_decoder.hpp"

namespace egofocus {

inline constexpr double kRadPerDeg = 0.017453292519943295;
inline constexpr double kG = 9.80665;

inline CanSignalRole entry(const std::string& message, const std::string& signal, CanRole role,
                           CanUnit unit = CanUnit::kSi, double scale = 1) {
  CanSignalRole result;
  std::strcpy(result.message, message.c_str());
  std::strcpy(result.signal, signal.c_str());
  result.role = role;
  result.unit = unit;
  result.scale = scale;
  return result;
}

inline CanMotionConfig config_of(std::initializer_list<CanSignalRole> entries) {
  CanMotionConfig config;
  for (const CanSignalRole& e : entries) config.signals[config.signal_count++] = e;
  return config;
}

inline CanFrame frame(std::int64_t t_us, std::uint32_t id, std::initializer_list<int> bytes,
                      bool extended = false) {
  CanFrame result;
  result.t_us = t_us;
  result.id = id;
  result.extended = extended;
  result.length = static_cast<std::uint8_t>(bytes.size());
  result.fd = bytes.size() > 8;
  std::size_t i = 0;
  for (const int byte : bytes) result.data[i++] = static_cast<std::uint8_t>(byte);
  return result;
}

// A configured decoder and all that it gave.
struct Bench {
  Bench(const CanMotionConfig& config, const Dbc& dbc) : decoder(std::make_unique<CanMotionDecoder>()) {
    REQUIRE(decoder->configure(config, dbc).ok());
  }
  void feed(const CanFrame& f) {
    MotionSamples out;
    decoder->feed(f, out);
    imu.insert(imu.end(), out.imu, out.imu + out.imu_count);
    odometry.insert(odometry.end(), out.odometry, out.odometry + out.odometry_count);
  }
  const CanMotionCounters& n() const { return decoder->counters(); }

  std::unique_ptr<CanMotionDecoder> decoder;
  std::vector<ImuSample> imu;
  std::vector<OdometrySample> odometry;
};

inline CanMotionConfig bosch() {
  constexpr auto kDeg = CanUnit::kDegPerSecond;
  constexpr auto kGs = CanUnit::kStandardGravity;
  return config_of(
      {entry("MM_TX1", "YawRate", CanRole::kGyroZ, kDeg), entry("MM_TX1", "AccelY", CanRole::kAccelY, kGs),
       entry("MM_TX1", "Counter1", CanRole::kCounter), entry("MM_TX2", "RollRate", CanRole::kGyroX, kDeg, -1),
       entry("MM_TX2", "AccelX", CanRole::kAccelX, kGs), entry("MM_TX2", "Counter2", CanRole::kCounter),
       entry("MM_TX3", "PitchRate", CanRole::kGyroY, kDeg), entry("MM_TX3", "AccelZ", CanRole::kAccelZ, kGs),
       entry("MM_TX3", "Counter3", CanRole::kCounter)});
}

// Three frames of one sample: +10, -20 and 5 deg/s; 0.1, -0.2 and 1 g.
inline CanFrame tx1(std::int64_t t, int counter) {
  return frame(t, 0x174, {0xD0, 0x87, 0, 75, 0x11, 0x83, counter, 0});
}
inline CanFrame tx2(std::int64_t t, int counter) {
  return frame(t, 0x178, {0x60, 0x70, 0, 0, 0xDF, 0x79, counter, 0});
}
inline CanFrame tx3(std::int64_t t, int counter) {
  return frame(t, 0x17C, {0xE8, 0x83, 0, 0, 0xA5, 0x9E, counter, 0});
}

}  // namespace egofocus
