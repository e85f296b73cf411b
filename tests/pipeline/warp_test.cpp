// The warp against a long double re-projection through the definition of rigid motion, against the
// first-order motion field, and against a plain loop over events and hypotheses.
#include "pipeline/warp.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "support/arena_block.hpp"

using namespace egofocus;

namespace {

using Real = long double;

struct Vec {
  Real x, y, z;
};
Vec operator+(Vec a, Vec b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Vec operator*(Vec a, Real s) {
  return {a.x * s, a.y * s, a.z * s};
}
Vec cross(Vec a, Vec b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

struct Motion {
  Vec velocity;  // of the camera's centre, camera frame
  Vec rate;
};

// The definition: a static point moves by dP/dt = -omega x P - T. Classical Runge-Kutta of order 4; `to_s`
// may lie before `from_s`.
Vec carry(const Motion& m, Vec p, Real seconds) {
  const int n = 200;
  const Real h = seconds / n;
  const auto slope = [&](Vec q) { return (cross(m.rate, q) + m.velocity) * Real(-1); };
  for (int i = 0; i < n; ++i) {
    const Vec a = slope(p);
    const Vec b = slope(p + a * (h / 2));
    const Vec c = slope(p + b * (h / 2));
    const Vec d = slope(p + c * h);
    p = p + (a + b * 2 + c * 2 + d) * (h / 6);
  }
  return p;
}

MotionSample sample(const Motion& m) {
  MotionSample s;
  const Vec v[2] = {m.velocity, m.rate};
  for (int k = 0; k < 2; ++k) {
    double* out = k == 0 ? s.velocity_m_s : s.angular_rate_rad_s;
    out[0] = static_cast<double>(v[k].x);
    out[1] = static_cast<double>(v[k].y);
    out[2] = static_cast<double>(v[k].z);
  }
  return s;
}

MotionKnot between(const MotionTrack& track, double share_of_window) {
  const double at = share_of_window * (MotionTrack::kKnots - 1);
  const int i = std::min(static_cast<int>(at), MotionTrack::kKnots - 2);
  MotionKnot knot;
  for (int k = 0; k < 9; ++k)
    knot.rotation[k] =
        track.knots[i].rotation[k] + (at - i) * (track.knots[i + 1].rotation[k] - track.knots[i].rotation[k]);
  for (int k = 0; k < 3; ++k)
    knot.centre_m[k] =
        track.knots[i].centre_m[k] + (at - i) * (track.knots[i + 1].centre_m[k] - track.knots[i].centre_m[k]);
  return knot;
}

const Intrinsics kGrid{240, 180, 335, 335, 119.5, 89.5};

}  // namespace

TEST_CASE("landing points agree with a re-projection to 0.1 px at 24 px of parallax and 0.3 rad", "[long]") {
  const Real duration_s = 0.2L;
  const Motion motions[] = {{{1.0L, 0.1L, 0}, {0, 1.5L, 0}},
                            {{0.2L, -0.3L, 4}, {0, 1.5L, 0}},
                            {{0.4L, 0.5L, -3}, {0.9L, -1.1L, 0.5L}},
                            {{0.8L, 0, 1}, {0, 0, 1.5L}}};
  Real worst_px = 0;
  int compared = 0;
  for (const Motion& motion : motions) {
    const MotionSample constant = sample(motion);
    MotionTrack track;
    integrate_track({&constant, 1}, 0, 200'000, track);
    LadderConfig config;
    config.span_px = 24;
    config.z_near_m = 0.05;  // the ladder alone limits: the whole window is used
    const HypothesisLadder ladder = choose_ladder(config, kGrid, track);
    REQUIRE(ladder.parallax_px * 63 / (ladder.count - 1) == Approx(24));
    std::mt19937 random(7);
    for (int i = 0; i < 3000; ++i) {
      // A point in the reference view, at the depth of a hypothesis...
      const int k = 1 + static_cast<int>(random() % 63);
      const Real depth = 1 / (static_cast<Real>(ladder.step_per_m) * k);
      const Real u = static_cast<Real>(random() % 24000) / 100;
      const Real v = static_cast<Real>(random() % 18000) / 100;
      const Vec there = Vec{(u - kGrid.cx_px) / kGrid.fx_px, (v - kGrid.cy_px) / kGrid.fy_px, 1} * depth;
      // ... seen earlier, by the motion's inverse ...
      const Real share = static_cast<Real>(random() % 10001) / 10000;
      const Vec then = carry(motion, there, -(1 - share) * duration_s);
      if (then.z <= 0 || std::abs(then.x) > then.z || std::abs(then.y) > then.z)
        continue;  // 90 degrees of view
      const Ray ray{static_cast<float>(then.x / then.z), static_cast<float>(then.y / then.z)};
      // ... lands where it came from.
      const LandingLine line =
          landing_line(ray, between(track, static_cast<double>(share)), kGrid, ladder.step_per_m, 64);
      REQUIRE(line.k_end > k);
      const Real landed_u = static_cast<Real>(line.u_q16 + k * line.du_q16) / 65536;
      const Real landed_v = static_cast<Real>(line.v_q16 + k * line.dv_q16) / 65536;
      worst_px = std::max(worst_px, std::hypot(landed_u - u, landed_v - v));
      ++compared;
    }
  }
  WARN("re-projection, " << compared << " points: worst error " << static_cast<double>(worst_px) << " px");
  CHECK(compared > 8000);
  CHECK(worst_px <= Real(0.1));
}

TEST_CASE("for short windows the exact form and the first-order motion field agree to first order") {
  const Motion motion{{1.0L, -0.4L, 5.0L}, {0.3L, 0.8L, -0.5L}};
  const MotionSample constant = sample(motion);
  const double u = 201;
  const double v = 33;
  const double depth = 6;
  const Ray ray{static_cast<float>((u - kGrid.cx_px) / kGrid.fx_px),
                static_cast<float>((v - kGrid.cy_px) / kGrid.fy_px)};
  const auto error_px = [&](std::int64_t length_us) {
    MotionTrack track;
    integrate_track({&constant, 1}, 0, length_us, track);
    const LandingLine line = landing_line(ray, track.knots[0], kGrid, 1 / depth / 16, 64);
    const double landed_u = (line.u_q16 + 16.0 * line.du_q16) / 65536;
    const double landed_v = (line.v_q16 + 16.0 * line.dv_q16) / 65536;
    // METHOD, section 1: V(d).
    const double f = kGrid.fx_px;
    const double a = u - kGrid.cx_px;
    const double b = v - kGrid.cy_px;
    const double* t = constant.velocity_m_s;
    const double* w = constant.angular_rate_rad_s;
    const double flow_u =
        (-f * t[0] + a * t[2]) / depth + (a * b * w[0] - (f * f + a * a) * w[1] + f * b * w[2]) / f;
    const double flow_v =
        (-f * t[1] + b * t[2]) / depth + ((f * f + b * b) * w[0] - a * b * w[1] - f * a * w[2]) / f;
    const double seconds = static_cast<double>(length_us) * 1e-6;
    CHECK(std::hypot(flow_u, flow_v) * seconds > 0.2);  // there is a motion to agree on
    return std::hypot(landed_u - u - flow_u * seconds, landed_v - v - flow_v * seconds);
  };
  const double at_1_ms = error_px(1000);
  const double at_20_ms = error_px(20'000);
  const double at_40_ms = error_px(40'000);
  CHECK(at_1_ms < 1e-2);
  CHECK(at_20_ms < 0.5);
  CHECK(at_40_ms / at_20_ms == Approx(4).epsilon(0.25));  // what is left is of second order
}

TEST_CASE("points behind the camera get no vote") {
  MotionKnot knot{{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
  const Ray ray{0.1f, -0.05f};
  SECTION("backwards by c_z: depths up to c_z in the reference view were behind") {
    knot.centre_m[2] = 0.5;
    // rho_k = k * 0.1; rho * c_z >= 1 from k = 20 on.
    CHECK(landing_line(ray, knot, kGrid, 0.1, 64).k_end == 20);
    CHECK(landing_line(ray, knot, kGrid, 0.1, 16).k_end == 16);
    knot.centre_m[2] = -0.5;
    CHECK(landing_line(ray, knot, kGrid, 0.1, 64).k_end == 64);
  }
  SECTION("turned away") {
    const double turned[9] = {-1, 0, 0, 0, 1, 0, 0, 0, -1};
    for (int i = 0; i < 9; ++i) knot.rotation[i] = turned[i];
    CHECK(landing_line(ray, knot, kGrid, 0.1, 64).k_end == 0);
  }
  SECTION("a pixel without a ray, and a slope beyond the Q16 range") {
    CHECK(landing_line({kNoRay, kNoRay}, knot, kGrid, 0.1, 64).k_end == 0);
    knot.centre_m[0] = 1000;
    const LandingLine line = landing_line(ray, knot, kGrid, 0.1, 64);
    CHECK(line.k_end == 1);
    CHECK(line.du_q16 == 0);
  }
  SECTION("whatever the numbers, positions stay inside the kernel's range") {
    std::mt19937 random(11);
    const auto any = [&](double largest) {
      return (static_cast<double>(random() % 20001) / 10000 - 1) * largest;
    };
    for (int i = 0; i < 20'000; ++i) {
      for (double& r : knot.rotation) r = any(1);
      for (double& c : knot.centre_m) c = any(std::pow(10, static_cast<double>(random() % 5) - 2));
      const int hypotheses = 8 * (1 + static_cast<int>(random() % 8));
      const LandingLine line = landing_line({static_cast<float>(any(3)), static_cast<float>(any(3))}, knot,
                                            kGrid, 0.05, hypotheses);
      const std::int64_t limit = std::int64_t{1} << 30;
      for (std::int64_t k : {0, hypotheses - 1}) {
        REQUIRE(std::abs(line.u_q16 + k * line.du_q16) < limit);
        REQUIRE(std::abs(line.v_q16 + k * line.dv_q16) < limit);
      }
      REQUIRE(line.k_end >= 0);
      REQUIRE(line.k_end <= hypotheses);
    }
  }
}

namespace {

Config small_config() {
  Config config;
  config.camera.intrinsics = {61, 47, 60, 62, 30, 23};
  config.ladder.hypotheses = 40;
  config.window.max_events = 3000;
  config.window.min_events = 0;
  return config;
}

struct Stack {
  std::vector<std::uint8_t> counts;
  std::vector<std::uint8_t> times;
  std::uint64_t votes;
  std::uint64_t behind;
};

Stack run(const Config& config, const std::vector<Event>& events, const MotionTrack& track,
          const HypothesisLadder& ladder, int parts) {
  test::RoomyArena arena;
  EventWindow window(config.window, config.camera.intrinsics, *arena);
  Warp warp(config, select_kernels(isa_bit(Isa::kScalar)), *arena);
  warp.prepare(config.camera);
  for (const Event& e : events) window.add(e);
  const auto selection = window.select(track.begin_us, track.end_us);
  // Parts in reverse order: none may lean on another.
  for (int part = parts - 1; part >= 0; --part) warp.project(window, selection, track, ladder, part, parts);
  for (int part = parts - 1; part >= 0; --part) warp.vote(part, parts);
  Stack stack{{}, {}, warp.votes(), warp.behind_camera()};
  for (int k = 0; k < config.ladder.hypotheses; ++k)
    stack.counts.insert(stack.counts.end(), warp.plane(k).begin(), warp.plane(k).end());
  for (int i = 0; i < warp.lines().count; ++i)
    stack.times.push_back(warp.lines().time_u8[static_cast<std::size_t>(i)]);
  return stack;
}

}  // namespace

TEST_CASE("the stack of warped events is that of a plain loop, and the same for any number of parts") {
  const Config config = small_config();
  const Motion motion{{0.4L, 0.1L, -6.0L}, {0.1L, 0.6L, 0.2L}};
  const MotionSample constant = sample(motion);
  MotionTrack track;
  const std::int64_t begin_us = (std::int64_t{1} << 32) - 30'000;  // across the wrap of stored times
  const std::int64_t end_us = begin_us + 90'001;
  integrate_track({&constant, 1}, begin_us, end_us, track);
  HypothesisLadder ladder;
  ladder.begin_us = begin_us;
  ladder.step_per_m = 0.06;
  ladder.count = config.ladder.hypotheses;

  std::mt19937 random(5);
  std::vector<Event> events;
  for (int i = 0; i < 2500; ++i) {
    Event e{begin_us + i * 36, static_cast<std::uint16_t>(random() % 61),
            static_cast<std::uint16_t>(random() % 47), 1};
    if (i % 3 == 0) e.x = e.y = 20;  // saturates somewhere
    events.push_back(e);
  }
  events.back().t_us = end_us;

  // Each event, each hypothesis, in doubles; what lies too near to a rounding edge is settled by the line
  // itself.
  std::vector<int> naive(61u * 47u * 40u);
  std::uint64_t votes = 0;
  std::uint64_t behind = 0;
  std::vector<std::uint8_t> times;
  int off_by_rounding = 0;
  for (const Event& e : events) {
    const double share = static_cast<double>(e.t_us - begin_us) / static_cast<double>(end_us - begin_us);
    times.push_back(static_cast<std::uint8_t>((e.t_us - begin_us) * 255 / (end_us - begin_us)));
    const MotionKnot knot = between(track, share);
    const Ray ray{static_cast<float>((e.x - 30.0) / 60), static_cast<float>((e.y - 23.0) / 62)};
    const LandingLine line = landing_line(ray, knot, config.camera.intrinsics, ladder.step_per_m, 40);
    const double* r = knot.rotation;
    const double rz = r[6] * ray.x + r[7] * ray.y + r[8];
    const double a = (r[0] * ray.x + r[1] * ray.y + r[2]) / rz;
    const double b = (r[3] * ray.x + r[4] * ray.y + r[5]) / rz;
    for (int k = 0; k < 40; ++k) {
      const double rho = k * ladder.step_per_m;
      if (rho * knot.centre_m[2] >= 1) {
        ++behind;
        continue;
      }
      const double u = 60 * (a + rho * (knot.centre_m[0] - knot.centre_m[2] * a)) + 30;
      const double v = 62 * (b + rho * (knot.centre_m[1] - knot.centre_m[2] * b)) + 23;
      const auto exact_u = static_cast<int>(std::floor(u + 0.5));
      const auto exact_v = static_cast<int>(std::floor(v + 0.5));
      const int column = static_cast<int>(std::floor((line.u_q16 + 1.0 * k * line.du_q16) / 65536 + 0.5));
      const int row = static_cast<int>(std::floor((line.v_q16 + 1.0 * k * line.dv_q16) / 65536 + 0.5));
      off_by_rounding += column != exact_u || row != exact_v;
      if (column < 0 || column >= 61 || row < 0 || row >= 47) continue;
      ++votes;
      ++naive[static_cast<std::size_t>((k * 47 + row) * 61 + column)];
    }
  }
  CHECK(behind > 0);
  CHECK(off_by_rounding < 200);  // of 100,000: Q16 against doubles

  const Stack one = run(config, events, track, ladder, 1);
  CHECK(one.votes == votes);
  CHECK(one.behind == behind);
  CHECK(one.times == times);
  int differ = 0;
  int saturated = 0;
  for (std::size_t i = 0; i < naive.size(); ++i) {
    differ += one.counts[i] != std::min(naive[i], 255);
    saturated += naive[i] > 255;
  }
  CHECK(differ == 0);
  CHECK(saturated > 0);
  for (int parts : {2, 3, 8}) {
    const Stack more = run(config, events, track, ladder, parts);
    CHECK(more.counts == one.counts);
    CHECK(more.times == one.times);
    CHECK(more.votes == one.votes);
    CHECK(more.behind == one.behind);
  }
}

TEST_CASE("an empty selection leaves an empty stack") {
  const Config config = small_config();
  const MotionSample still;
  MotionTrack track;
  integrate_track({&still, 1}, 0, 1000, track);
  const Stack none = run(config, {}, track, {}, 2);
  CHECK(none.votes == 0);
  CHECK(none.behind == 0);
  CHECK(std::count(none.counts.begin(), none.counts.end(), 0) ==
        static_cast<std::ptrdiff_t>(none.counts.size()));
}
