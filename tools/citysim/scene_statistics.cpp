#include "citysim/scene_statistics.hpp"

#include <algorithm>
#include <vector>

#include "citysim/logarithm.hpp"
#include "citysim/motion_field.hpp"
#include "citysim/renderer.hpp"
#include "citysim/true_ladder.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kRecording_s = 60;

/// Counts of one view.
struct Counts {
  std::array<double, kDepthBounds_m.size() + 2> depth{};
  double pixels = 0, textureless = 0, movers = 0, in_parallax = 0, nearer = 0, farther = 0;
  bool parallax = false, full_ladder = false;
  double speed_m_s = 0, rate_rad_s = 0, motion_px_s = 0;
};

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Of what is static at inverse depth `rho` there.
double image_speed_px_s(const Intrinsics& in, const RigidState& camera, int column, int row, double rho) {
  const double x = (column - in.cx_px) / in.fx_px;
  const double y = (row - in.cy_px) / in.fy_px;
  const auto [vx, vy] = motion_field(x, y, rho, camera.velocity_m_s, camera.rate_rad_s);
  return square_root(in.fx_px * in.fx_px * vx * vx + in.fy_px * in.fy_px * vy * vy);
}

bool is_blank(const std::vector<float>& log_light, int width, int x, int y) {
  float low = 1e9f;
  float high = -1e9f;
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      const float value = log_light[static_cast<std::size_t>((y + dy) * width + x + dx)];
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  return high - low < static_cast<float>(kBlank);
}

Counts count(const World& world, const Renderer& renderer, double t_s) {
  RenderScratch scratch;
  View view;
  const RigidState camera = world.camera_at(t_s);
  renderer.render(camera.pose, t_s, scratch, view);
  const HypothesisLadder ladder = true_ladder(world, static_cast<std::int64_t>(1e6 * t_s));
  const int width = world.grid.width_px;
  const int height = world.grid.height_px;
  std::vector<float> log_light(view.light.size());
  std::transform(view.light.begin(), view.light.end(), log_light.begin(),
                 [](float light) { return natural_log(std::max(light, 1e-5f)); });
  Counts counts;
  counts.parallax = ladder.has_parallax;
  counts.full_ladder = ladder.parallax_px >= kFullParallax_px;
  std::vector<double> speeds_px_s;
  counts.speed_m_s = square_root(dot(camera.velocity_m_s, camera.velocity_m_s));
  counts.rate_rad_s = square_root(dot(camera.rate_rad_s, camera.rate_rad_s));
  for (int y = 2; y < height - 2; ++y) {
    for (int x = 2; x < width - 2; ++x) {
      const std::size_t i = static_cast<std::size_t>(y * width + x);
      const double rho = static_cast<double>(view.inverse_depth[i]);
      std::size_t bin = kDepthBounds_m.size() + 1;  // the sky
      if (rho > 0) {
        bin = static_cast<std::size_t>(
            std::upper_bound(kDepthBounds_m.begin(), kDepthBounds_m.end(), 1.0 / rho) -
            kDepthBounds_m.begin());
      }
      counts.depth[bin] += 1;
      counts.pixels += 1;
      counts.textureless += is_blank(log_light, width, x, y);
      if (x % 4 == 0 && y % 4 == 0) speeds_px_s.push_back(image_speed_px_s(world.grid, camera, x, y, rho));
      if (rho <= 0) continue;
      const Vec3& v = world.scene.objects[static_cast<std::size_t>(view.object[i])].velocity_m_s;
      counts.movers += dot(v, v) > 0;
      if (!ladder.has_parallax) continue;
      const double index = rho / ladder.step_per_m;
      counts.in_parallax += 1;
      counts.nearer += index > ladder.count - 1;
      counts.farther += index < 0.5;
    }
  }
  counts.motion_px_s = median(speeds_px_s);
  return counts;
}

}  // namespace

SceneStatistics scene_statistics(Family family, int worlds, int views, std::uint64_t seed, Workers& workers) {
  SceneStatistics out;
  double pixels = 0;
  double in_parallax = 0;
  std::vector<double> motions_px_s;
  for (int w = 0; w < worlds; ++w) {
    const World world = make_world(family, {.duration_s = kRecording_s, .library = nullptr},
                                   seed + static_cast<std::uint64_t>(w));
    const Optics optics(CameraModel{world.grid, Distortion::kNone, {}});
    const Renderer renderer(world.scene, optics, world.blur);
    std::vector<Counts> counts(static_cast<std::size_t>(views));
    workers.for_each(views, [&](int i) {
      counts[static_cast<std::size_t>(i)] =
          count(world, renderer, 1.0 + (kRecording_s - 2.0) * i / std::max(1, views - 1));
    });
    double world_nearer = 0;
    double world_in_parallax = 0;
    for (const Counts& c : counts) {
      ++out.views;
      for (std::size_t i = 0; i < c.depth.size(); ++i) out.depth_share[i] += c.depth[i];
      pixels += c.pixels;
      out.textureless_share += c.textureless;
      out.mover_share += c.movers;
      world_nearer += c.nearer;
      world_in_parallax += c.in_parallax;
      out.full_ladder_views += c.full_ladder;
      if (c.parallax) motions_px_s.push_back(c.motion_px_s);
      out.farther_share += c.farther;
      out.no_parallax_views += !c.parallax;
      out.mean_speed_m_s += c.speed_m_s;
      out.top_speed_m_s = std::max(out.top_speed_m_s, c.speed_m_s);
      out.top_rate_rad_s = std::max(out.top_rate_rad_s, c.rate_rad_s);
    }
    out.nearer_share += world_nearer;
    in_parallax += world_in_parallax;
    out.worst_nearer_share =
        std::max(out.worst_nearer_share, world_nearer / std::max(1.0, world_in_parallax));
  }
  const double all_views = std::max(1.0, static_cast<double>(out.views));
  for (double& share : out.depth_share) share /= std::max(1.0, pixels);
  out.textureless_share /= std::max(1.0, pixels);
  out.mover_share /= std::max(1.0, pixels);
  out.nearer_share /= std::max(1.0, in_parallax);
  out.farther_share /= std::max(1.0, in_parallax);
  out.no_parallax_views /= all_views;
  out.full_ladder_views /= all_views;
  out.motion_px_s = median(motions_px_s);
  out.mean_speed_m_s /= all_views;
  return out;
}

}  // namespace egofocus::citysim
