#include "pipeline/velocity_noise.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "pipeline/check_config.hpp"

using namespace egofocus;

namespace {

constexpr int kTicks = 4000;
constexpr int kSamples = 20;
using Six = std::array<double, 6>;

/// Speeds 2 and 6 m/s by turns, rates 0.3 and 0.1 rad/s: means 4 m/s and 0.2 rad/s, in any direction.
std::vector<MotionSample> window() {
  std::vector<MotionSample> samples(kSamples);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i].t_us = static_cast<std::int64_t>(i) * 10'000;
    samples[i].velocity_m_s[i % 3] = i % 2 == 0 ? 2 : -6;
    samples[i].angular_rate_rad_s[(i + 1) % 3] = i % 2 == 0 ? 0.3 : -0.1;
  }
  return samples;
}

/// The errors of one window: what was added to each sample's six components.
std::vector<Six> errors_of(const VelocityNoise& noise, std::int64_t tick_us) {
  const std::vector<MotionSample> clean = window();
  std::vector<MotionSample> noisy = clean;
  add_velocity_noise(noise, tick_us, noisy);
  std::vector<Six> errors;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    Six six;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      six[axis] = noisy[i].velocity_m_s[axis] - clean[i].velocity_m_s[axis];
      six[axis + 3] = noisy[i].angular_rate_rad_s[axis] - clean[i].angular_rate_rad_s[axis];
    }
    errors.push_back(six);
  }
  return errors;
}

/// Mean and deviation of each component over kTicks windows, checked against `sigma_m_s` and `sigma_rad_s`
/// within five standard errors; `per_window`: independent draws in one window.
void check_moments(const VelocityNoise& noise, double sigma_m_s, double sigma_rad_s, int per_window) {
  Six sum{};
  Six squares{};
  double cross = 0;  // of neighbouring components
  for (int tick = 0; tick < kTicks; ++tick) {
    for (const Six& error : errors_of(noise, 50'000 * tick)) {
      for (std::size_t c = 0; c < 6; ++c) {
        sum[c] += error[c];
        squares[c] += error[c] * error[c];
      }
      cross += error[0] * error[1];
    }
  }
  const double n = static_cast<double>(kTicks) * kSamples;
  const double draws = static_cast<double>(kTicks) * per_window;
  for (std::size_t c = 0; c < 6; ++c) {
    CAPTURE(c);
    const double sigma = c < 3 ? sigma_m_s : sigma_rad_s;
    CHECK(std::abs(sum[c] / n) < 5 * sigma / std::sqrt(draws));
    CHECK(std::sqrt(squares[c] / n) == Approx(sigma).epsilon(5 / std::sqrt(2 * draws)));
  }
  CHECK(std::abs(cross / n) < 5 * sigma_m_s * sigma_m_s / std::sqrt(draws));
}

}  // namespace

TEST_CASE("noise by variance: sigma squared is a share of the mean norm") {
  check_moments({50, 7, NoiseKind::kVariance, NoiseDraw::kSample}, std::sqrt(0.5 * 4), std::sqrt(0.5 * 0.2),
                kSamples);
}

TEST_CASE("noise by deviation: sigma is a share of the mean norm") {
  check_moments({50, 7, NoiseKind::kDeviation, NoiseDraw::kSample}, 0.5 * 4, 0.5 * 0.2, kSamples);
}

TEST_CASE("noise per window moves all samples alike") {
  const VelocityNoise noise{20, 3, NoiseKind::kDeviation, NoiseDraw::kWindow};
  check_moments(noise, 0.2 * 4, 0.2 * 0.2, 1);
  const std::vector<Six> errors = errors_of(noise, 1000);
  for (const Six& error : errors) {
    for (std::size_t c = 0; c < 6; ++c) CHECK(error[c] == Approx(errors[0][c]).margin(1e-12));
  }
}

TEST_CASE("noise per sample is normal, too: one in three beyond 1 sigma, one in twenty beyond 2") {
  const VelocityNoise noise{100, 11, NoiseKind::kDeviation, NoiseDraw::kSample};
  int beyond_one = 0;
  int beyond_two = 0;
  for (int tick = 0; tick < kTicks; ++tick) {
    for (const Six& error : errors_of(noise, 50'000 * tick)) {
      beyond_one += std::abs(error[0]) > 4.0;
      beyond_two += std::abs(error[0]) > 8.0;
    }
  }
  CHECK(beyond_one / (1.0 * kTicks * kSamples) == Approx(0.3173).margin(0.01));
  CHECK(beyond_two / (1.0 * kTicks * kSamples) == Approx(0.0455).margin(0.004));
}

TEST_CASE("noise is the same for the same seed and tick, and differs otherwise") {
  const VelocityNoise noise{10, 5, NoiseKind::kVariance, NoiseDraw::kSample};
  VelocityNoise other = noise;
  other.seed = 6;
  CHECK(errors_of(noise, 1000) == errors_of(noise, 1000));
  CHECK(errors_of(noise, 1000) != errors_of(noise, 1001));
  CHECK(errors_of(noise, 1000) != errors_of(other, 1000));
  const std::vector<Six> errors = errors_of(noise, 1000);
  CHECK(errors[0] != errors[1]);
}

TEST_CASE("a robot that stands still gets no noise") {
  std::vector<MotionSample> still(kSamples);
  add_velocity_noise({100, 1, NoiseKind::kVariance, NoiseDraw::kSample}, 5, still);
  for (const MotionSample& sample : still) {
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(sample.velocity_m_s[axis] == 0);
      CHECK(sample.angular_rate_rad_s[axis] == 0);
    }
  }
}

TEST_CASE("a noisy track is the measured one at no noise, and one motion for any window of its tick") {
  MotionConfig config;
  config.source = MotionSource::kPoses;
  const auto motion = std::make_unique<EgoMotion>(config);
  for (int i = 0; i <= 60; ++i) {
    PoseSample pose;
    pose.t_us = 5000 * i;
    pose.position_m[0] = 1.5e-6 * static_cast<double>(pose.t_us);
    motion->add(pose);
  }
  motion->advance(300'000);
  const auto clean = std::make_unique<MotionTrack>();
  const auto noisy = std::make_unique<MotionTrack>();
  const auto part = std::make_unique<MotionTrack>();
  VelocityNoise noise{1e-12, 9, NoiseKind::kDeviation, NoiseDraw::kSample};
  REQUIRE(motion->track(100'000, 300'000, *clean));
  REQUIRE(noisy_track(noise, *motion, 100'000, 100'000, 300'000, *noisy));
  CHECK(clean->knots[0].centre_m[0] == Approx(-0.3));
  for (int i = 0; i < MotionTrack::kKnots; ++i)
    CHECK(noisy->knots[i].centre_m[0] == Approx(clean->knots[i].centre_m[0]).margin(1e-9));

  noise.percent = 30;
  REQUIRE(noisy_track(noise, *motion, 100'000, 100'000, 300'000, *noisy));
  CHECK(std::abs(noisy->knots[0].centre_m[1]) > 1e-4);
  // Knot 127 k / 2 of the half window is knot (127 + k) / 2 of the whole.
  REQUIRE(noisy_track(noise, *motion, 100'000, 200'000, 300'000, *part));
  CHECK(part->begin_us == 200'000);
  for (const int k : {1, 31, 101, 127}) {
    CAPTURE(k);
    for (int axis = 0; axis < 3; ++axis)
      CHECK(part->knots[k].centre_m[axis] == Approx(noisy->knots[(127 + k) / 2].centre_m[axis]).margin(1e-7));
  }

  const MotionTrack before = *part;
  CHECK_FALSE(noisy_track(noise, *motion, -100'000, 200'000, 300'000, *part));  // older than the poses
  CHECK(part->begin_us == before.begin_us);
}

TEST_CASE("a percentage that cannot be meant is refused") {
  Config config;
  config.camera.intrinsics = {346, 260, 300, 300, 172, 130};
  for (const double good : {0.0, 0.5, 1000.0}) {
    config.velocity_noise.percent = good;
    CHECK(check_config(config).ok());
  }
  for (const double bad : {-1.0, 1000.1, std::nan(""), std::numeric_limits<double>::infinity()}) {
    config.velocity_noise.percent = bad;
    CHECK(check_config(config).code() == StatusCode::kBadMotion);
  }
}
