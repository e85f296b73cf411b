// A robot that moves on an analytic path, and its sensors with their faults. Portable to the bit: + - * /
// sqrt and core/elementary only, so a hash of what a filter makes of it is the same on every machine.
#pragma once

#include <cstdint>
#include <functional>

#include "core/elementary.hpp"
#include "egofocus/types.hpp"

namespace egofocus::test {

/// splitmix64. Gaussian: the sum of 12 uniform numbers less 6 (variance exactly 1, tails end at 6 sigma).
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
  double gauss() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += uniform();
    return sum;
  }

 private:
  std::uint64_t state_;
};

struct Triple {
  double v[3];
};

inline Triple cross_of(const Triple& a, const Triple& b) {
  return {{a.v[1] * b.v[2] - a.v[2] * b.v[1], a.v[2] * b.v[0] - a.v[0] * b.v[2],
           a.v[0] * b.v[1] - a.v[1] * b.v[0]}};
}

/// Body velocity and rate as functions of time in seconds.
struct Path {
  std::function<Triple(double)> velocity_m_s;
  std::function<Triple(double)> rate_rad_s;
};

/// 0 before `from`, 1 after `to`, smooth in between.
inline double ramp(double t, double from, double to) {
  const double s = t <= from ? 0 : t >= to ? 1 : (t - from) / (to - from);
  return s * s * (3 - 2 * s);
}

/// A car: stands for 2 s, 12 m/s by 9 s, then faster and slower; turns left at 14-19 s and right at 22-26 s;
/// uneven road; slips 0.02 m/s sideways; stands again after 36 s.
inline Path car_path() {
  const auto moving = [](double t) { return ramp(t, 2, 9) * (1 - ramp(t, 30, 36)); };
  return {[moving](double t) {
            const double cruise = 12 + 3 * ramp(t, 18, 21) - 5 * ramp(t, 24, 28);
            const double slip = 0.02 * moving(t) * sine(0.9 * t);
            return Triple{{cruise * moving(t), slip, 0.5 * slip}};
          },
          [moving](double t) {
            const double m = moving(t);
            const double yaw =
                0.4 * ramp(t, 14, 15) * (1 - ramp(t, 18, 19)) - 0.5 * ramp(t, 22, 23) * (1 - ramp(t, 25, 26));
            return Triple{{0.03 * m * sine(5 * t), 0.04 * m * cosine(4.3 * t), m * yaw}};
          }};
}

/// A drone: hovers for nobody, moves in all six degrees from the first moment.
inline Path drone_path() {
  return {[](double t) {
            return Triple{{2.5 + 1.5 * sine(0.7 * t), 1.2 * cosine(0.9 * t), 0.8 * sine(1.3 * t)}};
          },
          [](double t) {
            return Triple{{0.4 * sine(1.7 * t), 0.5 * cosine(1.1 * t), 0.6 * sine(0.8 * t)}};
          }};
}

struct SensorFaults {
  Triple gyro_bias_rad_s = {{0, 0, 0}};
  double gyro_noise_rad_s = 0.005;
  Triple accel_bias_m_s2 = {{0, 0, 0}};
  double accel_noise_m_s2 = 0.15;
  double wheel_noise_m_s = 0.02;
  double wheel_step_m_s = 0.06;  // quantisation
  double wheel_scale = 0.02;
  double wheel_silent_below_m_s = 0;  // slower wheels give no pulses
  double body_velocity_noise_m_s = 0.05;
};

/// The true motion now, and what the sensors say.
class RobotSimulator {
 public:
  RobotSimulator(Path path, const SensorFaults& faults, std::uint64_t seed)
      : path_(std::move(path)), faults_(faults), random_(seed) {}

  [[nodiscard]] double t_s() const { return static_cast<double>(t_us_) * 1e-6; }
  [[nodiscard]] std::int64_t t_us() const { return t_us_; }
  [[nodiscard]] Triple velocity() const { return path_.velocity_m_s(t_s()); }
  [[nodiscard]] Triple rate() const { return path_.rate_rad_s(t_s()); }

  /// One millisecond on: g' = -omega x g by Runge and Kutta.
  void step() {
    const double t = t_s();
    const double h = 1e-3;
    const auto slope = [this](double at, const Triple& g) { return cross_of(g, path_.rate_rad_s(at)); };
    const auto plus = [](const Triple& a, const Triple& b, double s) {
      return Triple{{a.v[0] + s * b.v[0], a.v[1] + s * b.v[1], a.v[2] + s * b.v[2]}};
    };
    const Triple k1 = slope(t, gravity_);
    const Triple k2 = slope(t + h / 2, plus(gravity_, k1, h / 2));
    const Triple k3 = slope(t + h / 2, plus(gravity_, k2, h / 2));
    const Triple k4 = slope(t + h, plus(gravity_, k3, h));
    for (int i = 0; i < 3; ++i) gravity_.v[i] += h / 6 * (k1.v[i] + 2 * k2.v[i] + 2 * k3.v[i] + k4.v[i]);
    t_us_ += 1000;
  }

  ImuSample imu() {
    const double h = 1e-4;
    const Triple v = velocity();
    const Triple ahead = path_.velocity_m_s(t_s() + h);
    const Triple behind = path_.velocity_m_s(t_s() - h);
    const Triple w = rate();
    const Triple coriolis = cross_of(w, v);
    ImuSample sample;
    sample.t_us = t_us_;
    sample.has_gyro = true;
    sample.has_accel = true;
    for (int i = 0; i < 3; ++i) {
      const double push = (ahead.v[i] - behind.v[i]) / (2 * h) + coriolis.v[i] + gravity_.v[i];
      sample.gyro_rad_s[i] =
          w.v[i] + faults_.gyro_bias_rad_s.v[i] + faults_.gyro_noise_rad_s * random_.gauss();
      sample.accel_m_s2[i] = push + faults_.accel_bias_m_s2.v[i] + faults_.accel_noise_m_s2 * random_.gauss();
    }
    return sample;
  }

  OdometrySample wheel() {
    const double v = velocity().v[0];
    const bool silent = v == 0 || (v < faults_.wheel_silent_below_m_s && v > -faults_.wheel_silent_below_m_s);
    const double noisy =
        silent ? 0 : (1 + faults_.wheel_scale) * v + faults_.wheel_noise_m_s * random_.gauss();
    OdometrySample sample;
    sample.t_us = t_us_;
    sample.velocity_m_s[0] = faults_.wheel_step_m_s * floor_of(noisy / faults_.wheel_step_m_s + 0.5);
    return sample;
  }

  /// Covariance stated, with correlated x and y.
  OdometrySample body_velocity() {
    const Triple v = velocity();
    const double sigma = faults_.body_velocity_noise_m_s;
    const double n[3] = {random_.gauss(), random_.gauss(), random_.gauss()};
    OdometrySample sample;
    sample.t_us = t_us_;
    sample.kind = OdometrySample::Kind::kBodyVelocity;
    sample.velocity_m_s[0] = v.v[0] + sigma * n[0];
    sample.velocity_m_s[1] = v.v[1] + sigma * (0.6 * n[0] + 0.8 * n[1]);
    sample.velocity_m_s[2] = v.v[2] + 2 * sigma * n[2];
    const double s2 = sigma * sigma;
    const double covariance[6] = {s2, 0.6 * s2, 0, s2, 0, 4 * s2};
    for (int i = 0; i < 6; ++i) sample.covariance_m2_s2[i] = covariance[i];
    return sample;
  }

 private:
  Path path_;
  SensorFaults faults_;
  Random random_;
  std::int64_t t_us_ = 0;
  Triple gravity_ = {{0.3, -0.2, 9.8}};
};

}  // namespace egofocus::test
