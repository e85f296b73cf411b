// The ladder against sums over every pixel and against its own purpose: where a near point lands.
#include "pipeline/hypothesis_ladder.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>

using namespace egofocus;

namespace {

Intrinsics grid_346() {
  return {346, 260, 226, 231, 170.5, 139.25};
}

// Displacement of a point at depth 1/rho, straight from x_ref = r_x / r_z + rho (c_x - c_z r_x / r_z) with R
// = 1.
double brute_force_rms(const Intrinsics& g, const double c[3], double rho) {
  long double sum = 0;
  for (int v = 0; v < g.height_px; ++v) {
    for (int u = 0; u < g.width_px; ++u) {
      const long double x = (u - g.cx_px) / g.fx_px;
      const long double y = (v - g.cy_px) / g.fy_px;
      const long double du = g.fx_px * rho * (c[0] - c[2] * x);
      const long double dv = g.fy_px * rho * (c[1] - c[2] * y);
      sum += du * du + dv * dv;
    }
  }
  return static_cast<double>(std::sqrt(sum / (g.width_px * static_cast<long double>(g.height_px))));
}

std::unique_ptr<MotionTrack> constant_motion(double vx, double vy, double vz, double yaw,
                                             std::int64_t length_us) {
  MotionSample motion;
  motion.velocity_m_s[0] = vx;
  motion.velocity_m_s[1] = vy;
  motion.velocity_m_s[2] = vz;
  motion.angular_rate_rad_s[1] = yaw;
  auto track = std::make_unique<MotionTrack>();
  integrate_track({&motion, 1}, 1'000'000 - length_us, 1'000'000, *track);
  return track;
}

}  // namespace

TEST_CASE("rms displacement is the root mean square over all pixels") {
  const double centres[][3] = {{0.1, 0, 0}, {0, -0.2, 0}, {0, 0, -1.5}, {0.3, -0.02, -2}, {-0.01, 0.4, 0.7}};
  for (const auto& c : centres) {
    CHECK(rms_displacement_px_m(grid_346(), c) == Approx(brute_force_rms(grid_346(), c, 1)).epsilon(1e-12));
  }
  const Intrinsics odd{9, 13, 8, 7, 1, 11};
  CHECK(rms_displacement_px_m(odd, centres[3]) == Approx(brute_force_rms(odd, centres[3], 1)).epsilon(1e-12));
}

TEST_CASE("the parallax ladder spans its pixels over the window that is left") {
  LadderConfig config;
  config.span_px = 24;
  const Intrinsics grid = grid_346();
  SECTION("slow: the whole window is kept, and what is nearer than z_near is left out") {
    const auto track = constant_motion(0.3, 0, 0, 0.2, 200'000);
    const HypothesisLadder ladder = choose_ladder(config, grid, *track);
    REQUIRE(ladder.has_parallax);
    CHECK(ladder.begin_us == 800'000);
    CHECK(ladder.count == 24);
    CHECK((ladder.count - 1) * ladder.step_per_m > 1 / config.z_near_m);
    CHECK((ladder.count - 9) * ladder.step_per_m < 1 / config.z_near_m);
    CHECK(ladder.parallax_px == Approx(24 * 23.0 / 63));
    const double rho_max = 63 * ladder.step_per_m;
    CHECK(rho_max >= 1 / config.z_near_m);
    CHECK(brute_force_rms(grid, track->knots[0].centre_m, rho_max) == Approx(24).epsilon(1e-9));
  }
  SECTION("fast: the window is cut where z_near leaves the ladder, within one knot") {
    const auto track = constant_motion(2, 0, 12, 0, 200'000);
    const HypothesisLadder ladder = choose_ladder(config, grid, *track);
    REQUIRE(ladder.has_parallax);
    CHECK(ladder.begin_us > 800'000);
    CHECK(ladder.begin_us < 1'000'000);
    MotionTrack cut;
    MotionSample motion;
    motion.velocity_m_s[0] = 2;
    motion.velocity_m_s[2] = 12;
    integrate_track({&motion, 1}, ladder.begin_us, 1'000'000, cut);
    const double at_near = brute_force_rms(grid, cut.knots[0].centre_m, 1 / config.z_near_m);
    CHECK(at_near <= 24 * (1 + 1e-3));
    CHECK(at_near >= 24 * (1 - 1.0 / 30));
    CHECK(ladder.count == 64);
    CHECK(63 * ladder.step_per_m >= 1 / config.z_near_m * (1 - 1e-3));
    CHECK(ladder.parallax_px == Approx(24));
  }
}

TEST_CASE("the metric ladder ends at z_near and keeps the whole window") {
  LadderConfig config;
  config.kind = LadderKind::kMetric;
  config.hypotheses = 32;
  config.z_near_m = 1.6;
  const auto track = constant_motion(1, 0, 15, 0, 200'000);
  const HypothesisLadder ladder = choose_ladder(config, grid_346(), *track);
  REQUIRE(ladder.has_parallax);
  CHECK(ladder.begin_us == 800'000);
  CHECK(ladder.count == 32);
  CHECK(31 * ladder.step_per_m == Approx(1 / 1.6));
  CHECK(ladder.parallax_px == Approx(brute_force_rms(grid_346(), track->knots[0].centre_m, 1 / 1.6)));
}

TEST_CASE("a camera that shakes and comes back still has the parallax in between") {
  MotionSample motion[41];
  for (int i = 0; i < 41; ++i) {
    motion[i].t_us = 800'000 + i * 5000;
    motion[i].velocity_m_s[0] = 0.8 * std::sin(2 * 3.14159265358979 * i / 40.0);
  }
  MotionTrack track;
  integrate_track(motion, 800'000, 1'000'000, track);
  REQUIRE(std::abs(track.knots[0].centre_m[0]) < 1e-4);
  LadderConfig config;
  config.span_px = 24;
  double largest = 0;
  for (const MotionKnot& knot : track.knots)
    largest = std::max(largest, brute_force_rms(grid_346(), knot.centre_m, 1));
  const HypothesisLadder ladder = choose_ladder(config, grid_346(), track);
  REQUIRE(ladder.has_parallax);
  CHECK(ladder.step_per_m * 63 * largest == Approx(24));
}

TEST_CASE("no parallax: standstill, pure rotation, and a crawl below the minimum") {
  for (LadderKind kind : {LadderKind::kParallax, LadderKind::kMetric}) {
    LadderConfig config;
    config.kind = kind;
    CHECK_FALSE(choose_ladder(config, grid_346(), *constant_motion(0, 0, 0, 0, 200'000)).has_parallax);
    CHECK_FALSE(choose_ladder(config, grid_346(), *constant_motion(0, 0, 0, 1.5, 200'000)).has_parallax);
    // 5 px at 2 m with f = 226 px in 0.2 s: 0.221 m/s.
    CHECK_FALSE(choose_ladder(config, grid_346(), *constant_motion(0.220, 0, 0, 0, 200'000)).has_parallax);
    CHECK(choose_ladder(config, grid_346(), *constant_motion(0.2225, 0, 0, 0, 200'000)).has_parallax);
    config.min_parallax_px = 0;
    CHECK_FALSE(choose_ladder(config, grid_346(), *constant_motion(0, 0, 0, 1.5, 200'000)).has_parallax);
  }
}

TEST_CASE("a ladder that cannot be meant is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  LadderConfig config;
  CHECK(check_ladder(config).ok());
  SECTION("none") {
    config.hypotheses = 0;
  }
  SECTION("too many") {
    config.hypotheses = 72;
  }
  SECTION("no multiple of 8") {
    config.hypotheses = 36;
  }
  SECTION("z_near 0") {
    config.z_near_m = 0;
  }
  SECTION("z_near not a number") {
    config.z_near_m = nan;
  }
  SECTION("z_near far") {
    config.z_near_m = 101;
  }
  SECTION("span small") {
    config.span_px = 1;
  }
  SECTION("span not a number") {
    config.span_px = nan;
  }
  SECTION("minimum above span") {
    config.min_parallax_px = config.span_px + 1;
  }
  SECTION("minimum negative") {
    config.min_parallax_px = -1;
  }
  CHECK(check_ladder(config).code() == StatusCode::kBadLadder);
}
