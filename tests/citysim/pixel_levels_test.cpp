#include "citysim/pixel_levels.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "citysim/low_pass.hpp"
#include "citysim/pixel_crossings.hpp"
#include "citysim/random.hpp"

using namespace egofocus::citysim;
using egofocus::sim::Random;

namespace {

constexpr double kOne = 16777216.0;  // 2^24

// The closed form, by libm in long double.
double filtered(const LevelStep& s, double u) {
  const long double k = s.k;
  const long double rise = s.log1 - s.log0;
  const long double z = k * u;
  const long double lag = z > 0 ? -std::expm1(-z) / z : 1.0L;
  return static_cast<double>(s.log0 + rise * u + (s.level0 - s.log0) * std::exp(-z) - rise * u * lag);
}

}  // namespace

TEST_CASE("log levels are natural logarithms, whatever the light") {
  std::vector<float> light;
  for (double v = 1e-6; v < 1e6; v *= 1.0137) light.push_back(static_cast<float>(v));
  const std::size_t good = light.size();
  for (const float v : {0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()}) light.push_back(v);
  light.push_back(std::numeric_limits<float>::infinity());
  std::vector<Level> log(light.size());
  log_levels(light.data(), 0, static_cast<int>(light.size()), log.data());
  for (std::size_t i = 0; i < good; ++i)
    REQUIRE(std::abs(log[i] / kOne - std::log(static_cast<double>(light[i]))) < 2e-6);
  for (std::size_t i = good; i < good + 3; ++i) REQUIRE(std::abs(log[i] / kOne - std::log(1e-6)) < 2e-6);
  REQUIRE(std::abs(log.back() / kOne - std::log(1e6)) < 2e-6);

  const float dim = 0.01f;
  Level level = 0;
  log_levels(&dim, 0.03f, 1, &level);
  REQUIRE(std::abs(level / kOne - std::log(0.04)) < 2e-6);
}

TEST_CASE("the low pass is the closed form of exponential and ramp") {
  for (double k = 1e-5; k < 80; k *= 1.017) {
    const LowPassStep<double> exact = low_pass_step(k);
    REQUIRE(std::abs(exact.decay - std::exp(-k)) < 1e-11);
    REQUIRE(std::abs(exact.lag + std::expm1(-k) / k) < 1e-11);
    const auto narrow = static_cast<float>(k);
    const LowPassStep<float> fast = low_pass_step(narrow);
    const auto same = static_cast<double>(narrow);
    REQUIRE(std::abs(static_cast<double>(fast.decay) - std::exp(-same)) < 3e-7);
    REQUIRE(std::abs(static_cast<double>(fast.lag) + std::expm1(-same) / same) < 3e-7);
  }
  REQUIRE(low_pass_step(0.0).decay == 1.0);
  REQUIRE(low_pass_step(0.0).lag == 1.0);
  REQUIRE(low_pass_step(0.0f).decay == 1.0f);
  REQUIRE(low_pass_step(0.0f).lag == 1.0f);
}

TEST_CASE("filtered levels follow the corner of their light") {
  Random random(3);
  constexpr int kPixels = 1001;
  std::vector<float> light;
  std::vector<Level> log0, log1, level0, level1(kPixels);
  for (int i = 0; i < kPixels; ++i) {
    light.push_back(static_cast<float>(random.uniform(-0.1, 3)));
    for (auto* levels : {&log0, &log1, &level0}) {
      levels->push_back(static_cast<Level>(random.uniform(-8, 2) * kOne));
    }
  }
  const LowPassRate rate{0.1f, 1.7f};
  low_pass_levels(light.data(), rate, log0.data(), log1.data(), level0.data(), kPixels, level1.data());
  for (std::size_t i = 0; i < kPixels; ++i) {
    const double lit = std::max(0.0, static_cast<double>(light[i]));
    const LevelStep step{double(log0[i]), double(log1[i]), double(level0[i]), 0, 0.1 + 1.7 * lit, 1000};
    REQUIRE(std::abs(level1[i] - filtered(step, 1)) < 2e-5 * kOne);
  }
  REQUIRE(LowPassRate{100, 0}.of(1) == 80.0f);
}

TEST_CASE("a pixel is marked from the very level of its threshold on") {
  const Level upper = 500;
  const Level lower = -700;
  for (const Level level : {499, 500, 501, -699, -700, -701}) {
    std::uint8_t marked = 7;
    mark_crossed(&level, &upper, &lower, 1, &marked);
    REQUIRE(marked == (level >= 500 || level <= -700));
    mark_crossed(&level, &level, &level, &level, &upper, &lower, 1, &marked);
    REQUIRE(marked == (level >= 500 || level <= -700));
  }
}

TEST_CASE("crossings of a filtered pixel: each one, in order, at its time, turns included") {
  Random random(5);
  int found = 0;
  int turned = 0;
  for (int trial = 0; trial < 1200; ++trial) {
    LevelStep s{};
    s.log0 = std::round(random.uniform(-1.5, 1.5) * kOne);
    s.log1 = std::round(random.uniform(-1.5, 1.5) * kOne);
    s.level0 = std::round(random.uniform(-1, 1) * kOne);
    s.k = random.log_uniform(0.01, 20);
    s.span_us = 3000;
    s.level1 = std::round(filtered(s, 1));
    const auto threshold = static_cast<Level>(random.uniform(0.1, 0.5) * kOne);
    const auto above = static_cast<Level>(random.uniform(0.01, 1.0) * threshold);
    Comparators c{static_cast<Level>(s.level0) + above, 0, threshold, threshold};
    c.lower = c.upper - 2 * threshold;
    if (c.lower >= s.level0) continue;

    // The oracle walks the closed form in steps of 0.5 us.
    std::vector<Crossing> expected;
    std::vector<Level> thresholds;
    Comparators walked = c;
    const Level first_upper = c.upper;
    const Level first_lower = c.lower;
    for (int i = 1; i <= 6000; ++i) {
      const double level = i == 6000 ? s.level1 : filtered(s, i / 6000.0);
      while (level >= walked.upper) {
        expected.push_back({i * 0.5, true});
        thresholds.push_back(walked.upper);
        walked.lower = walked.upper - threshold;
        walked.upper += threshold;
      }
      while (level <= walked.lower) {
        expected.push_back({i * 0.5, false});
        thresholds.push_back(walked.lower);
        walked.upper = walked.lower + threshold;
        walked.lower -= threshold;
      }
    }
    // A marked pixel is one with crossings, or a harmless false alarm; never the other way round.
    const Level log0 = static_cast<Level>(s.log0), log1 = static_cast<Level>(s.log1);
    const Level level0 = static_cast<Level>(s.level0), level1 = static_cast<Level>(s.level1);
    std::uint8_t marked = 0;
    mark_crossed(&log0, &log1, &level0, &level1, &first_upper, &first_lower, 1, &marked);
    if (!expected.empty()) REQUIRE(marked == 1);

    std::vector<Crossing> crossings;
    find_crossings(s, c, crossings);
    // A peak that only just touches may hide between two steps of the oracle.
    if (crossings.size() != expected.size()) {
      REQUIRE(crossings.size() > expected.size());
      const double peak_u = std::log1p((s.level0 - s.log0) * s.k / (s.log1 - s.log0)) / s.k;
      REQUIRE(std::abs(filtered(s, peak_u) - filtered(s, peak_u + 0.5 / 3000)) < 1e-3 * kOne);
      continue;
    }
    for (std::size_t i = 0; i < crossings.size(); ++i) {
      REQUIRE(crossings[i].on == expected[i].on);
      // Where the level is nearly flat, a level of the last place is a longer time.
      const double slope = std::abs(filtered(s, expected[i].after_us / 3000) -
                                    filtered(s, (expected[i].after_us - 0.5) / 3000));
      if (slope > 50) REQUIRE(std::abs(crossings[i].after_us - expected[i].after_us) < 1.0);
      // The level itself, at the time that was found: right within 0.1 us, and the rounding of level1.
      const double u = crossings[i].after_us / 3000;
      const double per_tenth_us = std::abs(filtered(s, u + 5e-6) - filtered(s, u - 5e-6)) * 3.34;
      REQUIRE(std::abs(filtered(s, u) - thresholds[i]) <= per_tenth_us + 2);
      turned += i > 0 && crossings[i].on != crossings[i - 1].on;
    }
    REQUIRE(c.upper == walked.upper);
    REQUIRE(c.lower == walked.lower);
    found += static_cast<int>(crossings.size());
  }
  REQUIRE(found > 1500);
  REQUIRE(turned > 8);
}
