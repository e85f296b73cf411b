#include "citysim/renderer.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "small_worlds.hpp"

using namespace egofocus;
using namespace egofocus::citysim;

namespace {

/// Forward plumb-bob projection, written from its definition: where a point in camera coordinates is seen.
std::pair<double, double> seen_at(const CameraModel& camera, const Vec3& p) {
  const double x = p[0] / p[2];
  const double y = p[1] / p[2];
  const double* k = camera.coefficients;
  const double r2 = x * x + y * y;
  const double radial = 1 + k[0] * r2 + k[1] * r2 * r2 + k[4] * r2 * r2 * r2;
  const double u = x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x);
  const double v = y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y;
  return {camera.intrinsics.fx_px * u + camera.intrinsics.cx_px,
          camera.intrinsics.fy_px * v + camera.intrinsics.cy_px};
}

Surface plain() {
  Random random(3);
  return test_library()->surface(Pattern::kNoise, 2.0, random);
}

View render(const World& world, double t_s = 0) {
  const Optics optics(world.camera);
  const Renderer renderer(world.scene, optics, 0);
  RenderScratch scratch;
  View view;
  renderer.render(world.camera_at(t_s).pose, t_s, scratch, view);
  return view;
}

}  // namespace

TEST_CASE("the depth of a slanted plane is the analytic one, through the distortion") {
  World world = empty_world({0, 0, 0}, 1);
  // x = 4 + 0.3 y + 0.2 z, far larger than the view.
  const auto on_plane = [](double y, double z) { return Vec3{4 + 0.3 * y + 0.2 * z, y, z}; };
  Mesh mesh;
  mesh.quad(on_plane(30, -30), on_plane(-30, -30), on_plane(-30, 30), on_plane(30, 30), plain());
  world.scene.objects.push_back(mesh.take());
  finish_scene(world.scene);
  const View view = render(world);
  const Intrinsics& in = world.camera.intrinsics;
  double worst_px = 0;
  for (int v = 0; v < in.height_px; ++v) {
    for (int u = 0; u < in.width_px; ++u) {
      const double rho =
          static_cast<double>(view.inverse_depth[static_cast<std::size_t>(v * in.width_px + u)]);
      REQUIRE(rho > 0);
      // The one point at this depth that lies on the plane and is seen at this pixel: solve along the ray by
      // bisection on nothing but the forward projection. On the plane, camera (x, y, z) = (-Y, -Z, X), so a
      // depth z leaves a line of points; the pixel picks one. Newton on two unknowns with the depth as the
      // check.
      double y = 0;
      double z = 0;
      for (int i = 0; i < 30; ++i) {
        const auto at = [&](double a, double b) {
          const Vec3 p = on_plane(a, b);
          return seen_at(world.camera, {-p[1], -p[2], p[0]});
        };
        const auto [u0, v0] = at(y, z);
        const double h = 1e-5;
        const auto [uy, vy] = at(y + h, z);
        const auto [uz, vz] = at(y, z + h);
        const double a = (uy - u0) / h, b = (uz - u0) / h, c = (vy - v0) / h, d = (vz - v0) / h;
        const double det = a * d - b * c;
        y += (d * (u - u0) - b * (v - v0)) / det;
        z += (a * (v - v0) - c * (u - u0)) / det;
      }
      const double depth = on_plane(y, z)[0];
      worst_px = std::max(worst_px, std::abs(depth * rho - 1));
    }
  }
  CHECK(worst_px < 2e-6);
}

TEST_CASE("a box hides the wall behind it exactly where its outline is") {
  World world = empty_world({0, 0, 0}, 1);
  Mesh mesh;
  mesh.quad({5, 30, -30}, {5, -30, -30}, {5, -30, 30}, {5, 30, 30}, plain());
  world.scene.objects.push_back(mesh.take());
  mesh.box(Place{{3, 0.4, -0.5}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, 1.0, 0.8, 0.9, plain(), plain());
  world.scene.objects.push_back(mesh.take());
  finish_scene(world.scene);
  const View view = render(world);
  const Optics optics(world.camera);
  int box = 0;
  for (int v = 0; v < optics.height(); ++v) {
    for (int u = 0; u < optics.width(); ++u) {
      const Optics::Ray ray = optics.ray(u, v);
      // Slab test in world axes: direction (1, -x, -y), the box [2.5, 3.5] x [0, 0.8] x [-0.5, 0.4].
      const double direction[3] = {1, -ray.x, -ray.y};
      const double low[3] = {2.5, 0.0, -0.5};
      const double high[3] = {3.5, 0.8, 0.4};
      double enter = 0;
      double leave = 1e9;
      for (int i = 0; i < 3; ++i) {
        const double a = low[i] / direction[i];
        const double b = high[i] / direction[i];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
      }
      if (std::abs(enter - leave) < 1e-4) continue;  // grazes an edge
      const double expected = enter < leave ? 1 / enter : 0.2;
      const std::size_t at = static_cast<std::size_t>(v * optics.width() + u);
      CAPTURE(u, v);
      REQUIRE(static_cast<double>(view.inverse_depth[at]) == Approx(expected).epsilon(1e-5));
      REQUIRE(view.object[at] == (enter < leave ? 1 : 0));
      box += enter < leave;
    }
  }
  CHECK(box > 500);
}

TEST_CASE("neighbours leave no crack: a thousand triangles cover the view") {
  World world = empty_world({0, 0, 0}, 1);
  Random random(5);
  Mesh mesh;
  constexpr int kSide = 24;
  Vec3 nodes[kSide + 1][kSide + 1];
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j) {
      nodes[i][j] = {3 + random.uniform(-0.3, 0.3), 0.4 * (kSide / 2 - i) + random.uniform(-0.1, 0.1),
                     0.4 * (j - kSide / 2) + random.uniform(-0.1, 0.1)};
    }
  }
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const Vec3 &a = nodes[i][j], &b = nodes[i + 1][j], &c = nodes[i + 1][j + 1], &d = nodes[i][j + 1];
      mesh.triangle(a, b, c, {0, 0}, {1, 0}, {1, 1}, plain());
      mesh.triangle(a, c, d, {0, 0}, {1, 1}, {0, 1}, plain());
    }
  }
  world.scene.objects.push_back(mesh.take());
  finish_scene(world.scene);
  const View view = render(world);
  for (const float rho : view.inverse_depth) REQUIRE(rho > 0);
}

TEST_CASE("a texture point stays on its surface point when the camera moves") {
  World world = empty_world({0, 0.5, 0}, 1);  // to the left
  Mesh mesh;
  mesh.quad({2, 30, -30}, {2, -30, -30}, {2, -30, 30}, {2, 30, 30}, plain());
  world.scene.objects.push_back(mesh.take());
  finish_scene(world.scene);
  world.camera.distortion = Distortion::kNone;
  // 0.5 m/s at 2 m: 113 * 0.5 / 2 px/s; after 8 / 28.25 s the picture has moved by 8 px.
  const View before = render(world, 0);
  const View after = render(world, 8.0 / 28.25);
  const std::size_t width = 173;
  for (std::size_t v = 20; v < 110; ++v) {
    for (std::size_t u = 20; u < 150; ++u) {
      REQUIRE(after.light[v * width + u] == Approx(before.light[v * width + u - 8]).margin(2e-4));
    }
  }
}
