// The window's track against independent oracles: fine-step numerical integration in long double, and
// analytic motion.
#include "pipeline/motion_track.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "pipeline/ego_motion.hpp"

using namespace egofocus;

namespace {

using Real = long double;
struct V {
  Real x, y, z;
};
struct M {
  Real m[3][3];
};

V operator+(V a, V b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
V operator-(V a, V b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
V operator*(V a, Real s) {
  return {a.x * s, a.y * s, a.z * s};
}
V cross_of(V a, V b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
V apply(const double* r, V p) {
  return {r[0] * p.x + r[1] * p.y + r[2] * p.z, r[3] * p.x + r[4] * p.y + r[5] * p.z,
          r[6] * p.x + r[7] * p.y + r[8] * p.z};
}
Real length(V a) {
  return std::sqrt(a.x * a.x + a.y * a.y + a.z * a.z);
}

/// (T, omega) at t, straight from the definition of the samples.
void twist_at(const std::vector<MotionSample>& samples, Real t_us, V& velocity, V& rate) {
  std::size_t i = 0;
  while (i + 2 < samples.size() && static_cast<Real>(samples[i + 1].t_us) <= t_us) ++i;
  const MotionSample& a = samples[i];
  const MotionSample& b = samples[i + 1];
  const Real s = (t_us - static_cast<Real>(a.t_us)) / static_cast<Real>(b.t_us - a.t_us);
  const auto mix = [s](const double* p, const double* q) {
    return V{p[0] + (q[0] - p[0]) * s, p[1] + (q[1] - p[1]) * s, p[2] + (q[2] - p[2]) * s};
  };
  velocity = mix(a.velocity_m_s, b.velocity_m_s);
  rate = mix(a.angular_rate_rad_s, b.angular_rate_rad_s);
}

/// Carries a static point from t to the end by dP/dt = -omega x P - T: the definition, by midpoint steps of
/// ~0.5 us.
V carry(const std::vector<MotionSample>& samples, V p, Real from_us, Real to_us) {
  const int n = static_cast<int>((to_us - from_us) * 2) + 1;
  const Real h_us = (to_us - from_us) / n;
  for (int i = 0; i < n; ++i) {
    V velocity, rate;
    twist_at(samples, from_us + h_us * i, velocity, rate);
    const auto slope = [&](V q) { return (cross_of(rate, q) + velocity) * Real(-1); };
    const V middle = p + slope(p) * (h_us * Real(0.5e-6));
    twist_at(samples, from_us + h_us * (i + Real(0.5)), velocity, rate);
    p = p + slope(middle) * (h_us * Real(1e-6));
  }
  return p;
}

std::vector<MotionSample> weave(std::int64_t begin_us, std::int64_t end_us, int n, double yaw_rad) {
  std::vector<MotionSample> samples;
  const double duration_s = static_cast<double>(end_us - begin_us) * 1e-6;
  for (int i = 0; i < n; ++i) {
    const double s = static_cast<double>(i) / (n - 1);
    MotionSample m;
    m.t_us = begin_us + (end_us - begin_us) * i / (n - 1);
    m.velocity_m_s[0] = 0.8 * std::sin(5 * s);
    m.velocity_m_s[1] = -0.3 + 0.4 * s;
    m.velocity_m_s[2] = 12 - 3 * s;
    m.angular_rate_rad_s[0] = 0.4 * std::cos(7 * s);
    m.angular_rate_rad_s[1] = yaw_rad / duration_s * (1 + 0.5 * std::sin(6 * s));
    m.angular_rate_rad_s[2] = 0.5 * std::sin(4 * s);
    samples.push_back(m);
  }
  return samples;
}

}  // namespace

TEST_CASE("a track agrees with fine-step integration of the definition", "[long]") {
  const std::int64_t begin_us = 1'000'000;
  const std::int64_t end_us = 1'200'000;
  const auto samples = weave(begin_us, end_us, 20, 0.3);
  auto track = std::make_unique<MotionTrack>();
  integrate_track(samples, begin_us, end_us, *track);
  CHECK(track->begin_us == begin_us);
  CHECK(track->end_us == end_us);

  Real worst_centre = 0;
  Real worst_turn = 0;
  for (int i : {0, 1, 17, 63, 100, 126, 127}) {
    const MotionKnot& knot = track->knots[i];
    const Real t_us = begin_us + Real(end_us - begin_us) * i / 127;
    const V origin = carry(samples, {0, 0, 0}, t_us, end_us);
    worst_centre =
        std::max(worst_centre, length(origin - V{knot.centre_m[0], knot.centre_m[1], knot.centre_m[2]}));
    for (V axis : {V{1, 0, 0}, V{0, 1, 0}, V{0, 0, 1}}) {
      const V turned = carry(samples, axis, t_us, end_us) - origin;
      worst_turn = std::max(worst_turn, length(turned - apply(knot.rotation, axis)));
    }
  }
  const V whole = apply(track->knots[0].rotation, {0, 0, 1});
  WARN("track, 0.2 s, 20 samples, turn of " << static_cast<double>(std::acos(whole.z)) << " rad: worst error "
                                            << static_cast<double>(worst_centre) << " m, "
                                            << static_cast<double>(worst_turn) << " rad");
  CHECK(std::acos(whole.z) > 0.3);
  CHECK(worst_centre < 1e-6);
  CHECK(worst_turn < 1e-6);
}

TEST_CASE("linear interpolation between knots errs less than 0.001 px") {
  // A constant turn of 0.3 rad in the window: R(t) and c(t) are known in closed form (a circle).
  const double turn_rad = 0.3;
  const double duration_s = 0.2;
  const double speed_m_s = 10;
  MotionSample motion;
  motion.velocity_m_s[2] = speed_m_s;
  motion.angular_rate_rad_s[1] = turn_rad / duration_s;
  auto track = std::make_unique<MotionTrack>();
  integrate_track({&motion, 1}, 0, 200'000, *track);

  const double f_px = 335;
  double worst_px = 0;
  for (int i = 0; i < 127; ++i) {
    for (double share : {0.25, 0.5, 0.75}) {
      const double angle = turn_rad * (1 - (i + share) / 127);  // still to turn
      const double radius = speed_m_s * duration_s / turn_rad;
      const double centre_x = radius * (1 - std::cos(angle));
      const double centre_z = -radius * std::sin(angle);
      const MotionKnot& a = track->knots[i];
      const MotionKnot& b = track->knots[i + 1];
      for (double x : {-0.5, 0.0, 0.5}) {
        for (double y : {-0.4, 0.4}) {
          for (double rho : {0.0, 0.5}) {
            // dP/dt = -omega x P with omega along y (down): the scene turns from +x over z to -x.
            const double true_x = std::cos(angle) * x - std::sin(angle);
            const double true_z = std::sin(angle) * x + std::cos(angle);
            const V r =
                apply(a.rotation, {x, y, 1}) * Real(1 - share) + apply(b.rotation, {x, y, 1}) * Real(share);
            const double cx = a.centre_m[0] + (b.centre_m[0] - a.centre_m[0]) * share;
            const double cz = a.centre_m[2] + (b.centre_m[2] - a.centre_m[2]) * share;
            const double u =
                static_cast<double>(r.x / r.z) + rho * (cx - cz * static_cast<double>(r.x / r.z));
            const double v = static_cast<double>(r.y / r.z) + rho * (0 - cz * static_cast<double>(r.y / r.z));
            const double u_true = true_x / true_z + rho * (centre_x - centre_z * true_x / true_z);
            const double v_true = y / true_z + rho * (0 - centre_z * y / true_z);
            worst_px = std::max(worst_px, f_px * std::hypot(u - u_true, v - v_true));
          }
        }
      }
    }
  }
  WARN("128 knots, 0.3 rad, f = 335 px: interpolation errs " << worst_px << " px at most");
  CHECK(worst_px < 1e-3);
}
