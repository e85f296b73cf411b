#include "support/true_parallax.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace egofocus::sim {
namespace {

const PoseSample& pose_at(std::span<const PoseSample> poses, std::int64_t t_us) {
  for (const PoseSample& pose : poses) {
    if (pose.t_us == t_us) return pose;
  }
  throw std::runtime_error("no pose at this time");
}

/// q^-1 v q
CentreShift rotate_back(const double (&q)[4], const double (&v)[3]) {
  const double x = -q[0], y = -q[1], z = -q[2], w = q[3];
  const double tx = 2 * (y * v[2] - z * v[1]);
  const double ty = 2 * (z * v[0] - x * v[2]);
  const double tz = 2 * (x * v[1] - y * v[0]);
  return {v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx};
}

}  // namespace

CentreShift centre_shift(std::span<const PoseSample> poses, std::int64_t then_us, std::int64_t now_us) {
  const PoseSample& then = pose_at(poses, then_us);
  const PoseSample& now = pose_at(poses, now_us);
  double moved[3];
  for (int i = 0; i < 3; ++i) moved[i] = then.position_m[i] - now.position_m[i];
  return rotate_back(now.orientation_xyzw, moved);
}

std::vector<double> parallax_px(const CentreShift& c, const Intrinsics& grid,
                                std::span<const float> depth_m) {
  std::vector<double> parallax(depth_m.size(), 0.0);
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    if (!(depth_m[i] > 0)) continue;
    const auto width = static_cast<std::size_t>(grid.width_px);
    const double x = (static_cast<double>(i % width) - grid.cx_px) / grid.fx_px;
    const double y = (static_cast<double>(i / width) - grid.cy_px) / grid.fy_px;
    parallax[i] = std::hypot(grid.fx_px * (c.x - c.z * x), grid.fy_px * (c.y - c.z * y)) /
                  static_cast<double>(depth_m[i]);
  }
  return parallax;
}

std::int64_t window_begin_us(std::span<const PoseSample> poses, const Config& config, std::int64_t tick_us) {
  const auto pixels =
      static_cast<std::size_t>(config.grid.width_px) * static_cast<std::size_t>(config.grid.height_px);
  const std::vector<float> near(pixels, static_cast<float>(config.ladder.z_near_m));
  std::int64_t begin_us = tick_us;
  for (auto pose = poses.rbegin(); pose != poses.rend(); ++pose) {
    if (pose->t_us > tick_us) continue;
    if (pose->t_us < tick_us - config.window.max_age_us) break;
    double squares = 0;
    for (const double px : parallax_px(centre_shift(poses, pose->t_us, tick_us), config.grid, near))
      squares += px * px;
    if (std::sqrt(squares / static_cast<double>(pixels)) > config.ladder.span_px) break;
    begin_us = pose->t_us;
  }
  return begin_us;
}

}  // namespace egofocus::sim
