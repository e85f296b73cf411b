// A small scene for whole-engine tests: a camera slides to the right past a dotted wall at constant distance.
// Everything is a function of time alone: events and poses of any span can be asked for, and always are the
// same.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "egofocus/config.hpp"
#include "egofocus/types.hpp"

namespace egofocus::test {

class SlidingScene {
 public:
  static constexpr double kSpeed_m_s = 0.5;
  static constexpr double kDistance_m = 1.0;
  static constexpr int kWidth = 64;
  static constexpr int kHeight = 48;
  static constexpr double kFocal_px = 60;
  static constexpr std::int64_t kEventSpacing_us = 100;
  static constexpr std::int64_t kPoseSpacing_us = 5000;

  SlidingScene() {
    std::mt19937 random(77);
    for (Dot& dot : dots_) dot = {static_cast<int>(random() % 1024), static_cast<int>(random() % kHeight)};
    for (std::size_t& i : order_) i = random() % kDots;
  }

  static Config config() {
    Config config;
    config.backend = Backend::kFocus;
    config.camera.intrinsics = {kWidth, kHeight, kFocal_px, kFocal_px, 31.5, 23.5};
    config.ladder.hypotheses = 32;
    config.ladder.z_near_m = 0.5;
    config.ladder.span_px = 24;
    config.window.max_events = 4000;
    config.window.min_events = 100;
    config.window.max_age_us = 200'000;
    config.motion.source = MotionSource::kPoses;
    config.rings = {1u << 14, 64, 64, 256};
    return config;
  }

  /// Events with begin_us < t <= end_us.
  [[nodiscard]] std::vector<Event> events(std::int64_t begin_us, std::int64_t end_us) const {
    std::vector<Event> out;
    for (std::int64_t n = begin_us / kEventSpacing_us + 1; n * kEventSpacing_us <= end_us; ++n) {
      const std::int64_t t_us = n * kEventSpacing_us;
      const Dot& dot = dots_[order_[static_cast<std::size_t>(n) % kSequence]];
      // Dots come round again every 1024 px; integers only, 30 px/s.
      const std::int64_t moved_px = t_us * 30 / 1'000'000;
      const std::int64_t x = (dot.x - moved_px) & 1023;
      const std::int64_t folded = x % kWidth;
      out.push_back({t_us, static_cast<std::uint16_t>(folded), static_cast<std::uint16_t>(dot.y),
                     static_cast<std::uint8_t>(n & 1)});
    }
    return out;
  }

  /// Poses with begin_us < t <= end_us.
  [[nodiscard]] static std::vector<PoseSample> poses(std::int64_t begin_us, std::int64_t end_us) {
    std::vector<PoseSample> out;
    for (std::int64_t n = begin_us / kPoseSpacing_us + 1; n * kPoseSpacing_us <= end_us; ++n) {
      PoseSample pose;
      pose.t_us = n * kPoseSpacing_us;
      pose.position_m[0] = kSpeed_m_s * static_cast<double>(pose.t_us) * 1e-6;
      out.push_back(pose);
    }
    return out;
  }

  /// The same slide as odometry of the body: the default camera looks along body x, so right is -y.
  [[nodiscard]] static std::vector<OdometrySample> odometry(std::int64_t begin_us, std::int64_t end_us) {
    std::vector<OdometrySample> out;
    for (std::int64_t n = begin_us / kPoseSpacing_us + 1; n * kPoseSpacing_us <= end_us; ++n) {
      OdometrySample sample;
      sample.t_us = n * kPoseSpacing_us;
      sample.kind = OdometrySample::Kind::kBodyVelocity;
      sample.velocity_m_s[1] = -kSpeed_m_s;
      out.push_back(sample);
    }
    return out;
  }

  [[nodiscard]] static std::vector<ImuSample> imu(std::int64_t begin_us, std::int64_t end_us) {
    std::vector<ImuSample> out;
    for (std::int64_t n = begin_us / kPoseSpacing_us + 1; n * kPoseSpacing_us <= end_us; ++n) {
      ImuSample sample;
      sample.t_us = n * kPoseSpacing_us;
      sample.has_gyro = sample.has_accel = true;
      sample.accel_m_s2[2] = 9.81;
      out.push_back(sample);
    }
    return out;
  }

 private:
  static constexpr std::size_t kDots = 600;
  static constexpr std::size_t kSequence = 4096;
  struct Dot {
    int x, y;
  };
  Dot dots_[kDots];
  std::size_t order_[kSequence];
};

}  // namespace egofocus::test
