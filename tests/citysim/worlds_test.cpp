// What the families promise: nothing in the way, parallax, a near limit that fits, and something to see.
#include <algorithm>
#include <catch2/catch.hpp>

#include "citysim/near_limit.hpp"
#include "citysim/renderer.hpp"
#include "citysim/sample.hpp"
#include "citysim/scene_statistics.hpp"
#include "small_worlds.hpp"

using namespace egofocus;
using namespace egofocus::citysim;

namespace {

/// A camera that glides along x, `height_m` above an endless floor, or before a wall.
World gliding_world(double height_m) {
  World world = empty_world({0.5, 0, 0}, 2);
  Mesh mesh;
  const double z = -height_m;
  mesh.quad({-500, -500, z}, {500, -500, z}, {500, 500, z}, {-500, 500, z},
            Surface{.texture = 0, .metres = 1, .colour = {1, 1, 1}, .emission = 0});
  world.scene.objects.push_back(mesh.take());
  finish_scene(world.scene);
  return world;
}

double near_limit_of(const World& world, double share) {
  return near_limit_m(world.scene, world.trajectory, world.mount, world.grid, share);
}

/// What tells two worlds apart.
std::uint64_t digest(const World& world) {
  std::uint64_t hash = 0;
  const auto mix = [&](double value) {
    hash = mix_bits(hash ^ static_cast<std::uint64_t>(static_cast<std::int64_t>(1e6 * value)));
  };
  for (const Object& object : world.scene.objects) {
    for (const Polygon& polygon : object.polygons) {
      for (const Vec3& corner : polygon.corners) mix(corner[0] + 3 * corner[1] + 7 * corner[2]);
      mix(polygon.steady.offset);
      mix(polygon.texture);
    }
  }
  mix(world.camera_at(1.5).pose.position[0]);
  mix(world.z_near_m);
  mix(world.sensor.threshold_on);
  return hash;
}

/// The nearest depth in sight along the way, ten looks a second.
double nearest_m(const World& world, double duration_s) {
  CameraModel camera;
  camera.intrinsics = {64, 48, 42, 42, 31.5, 23.5};
  const Optics optics(camera);
  const Renderer renderer(world.scene, optics, 0);
  RenderScratch scratch;
  View view;
  float nearest = 0;
  for (double t = 0; t < duration_s; t += 0.1) {
    renderer.render(world.camera_at(t).pose, t, scratch, view);
    nearest = std::max(nearest, *std::max_element(view.inverse_depth.begin(), view.inverse_depth.end()));
  }
  return nearest > 0 ? 1 / static_cast<double>(nearest) : 1e9;
}

}  // namespace

TEST_CASE("the near limit is the depth that the asked share of what is seen falls short of") {
  // A floor `h` below a level camera is at depth h / y in the rows y > 0 of the picture, so the lowest rows,
  // `share` of them all, are nearer than h / y of the highest one of these.
  const World world = gliding_world(0.8);
  for (const double share : {0.03, 0.1, 0.25}) {
    const Intrinsics& in = world.grid;
    const double below_px = (1 - share) * in.height_px - 0.5 - in.cy_px;
    constexpr double kOff_px = 2;  // most of a row of the coarse looks
    INFO(share);
    CHECK(near_limit_of(world, share) > 0.8 * in.fy_px / (below_px + kOff_px));
    CHECK(near_limit_of(world, share) < 0.8 * in.fy_px / (below_px - kOff_px));
  }
  CHECK(near_limit_of(gliding_world(400), 0.1) == kFarthest_m);
  CHECK(near_limit_of(gliding_world(0.01), 0.1) == kNearest_m);
  CHECK(near_limit_of(empty_world({0, 0, 0}, 1), 0.1) == kFarthest_m);
}

TEST_CASE("a seed makes the same world each time, another seed and another family another") {
  const WorldOptions options{.width_px = 173, .height_px = 130, .duration_s = 3, .library = test_library()};
  std::vector<std::uint64_t> seen;
  for (const FamilyName& family : families()) {
    for (const std::uint64_t seed : {1u, 2u}) {
      const std::uint64_t hash = digest(make_world(family.family, options, seed));
      INFO(family.name << " " << seed);
      CHECK(hash == digest(make_world(family.family, options, seed)));
      CHECK(std::count(seen.begin(), seen.end(), hash) == 0);
      seen.push_back(hash);
    }
  }
}

TEST_CASE("no robot drives or flies into anything") {
  const double duration_s = 15;
  for (const FamilyName& family : families()) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      const World world =
          make_world(family.family, {.duration_s = duration_s, .library = test_library()}, seed);
      const double nearest = nearest_m(world, duration_s);
      INFO(family.name << " " << seed << ": " << nearest << " m");
      CHECK(nearest > 0.05);
      CHECK(world.z_near_m >= kNearest_m);
      CHECK(world.z_near_m <= kFarthest_m);
    }
  }
}

TEST_CASE("the families have parallax, little that is too near, and both texture and blank surfaces") {
  Workers workers(2);
  for (const FamilyName& family : families()) {
    const SceneStatistics s = scene_statistics(family.family, 4, 16, 1, workers);
    WARN(family.name << ": nearer " << s.nearer_share << " (worst world " << s.worst_nearer_share
                     << "), full ladder " << s.full_ladder_views << ", no parallax " << s.no_parallax_views
                     << ", " << s.motion_px_s << " px/s, blank " << s.textureless_share);
    CHECK(s.nearer_share > 0);
    CHECK(s.nearer_share < 0.05);
    CHECK(s.worst_nearer_share < 0.12);
    CHECK(s.farther_share < 0.05);
    CHECK(s.no_parallax_views < 0.4);
    CHECK(s.full_ladder_views > 0.25);
    CHECK(s.motion_px_s > 15);
    CHECK(s.textureless_share > 0.1);
    CHECK(s.textureless_share < 0.75);
    const bool town = family.family < Family::kRoom;
    CHECK((s.depth_share.back() > 0.02) == town);  // the sky
    CHECK((s.mover_share > 0) == town);
  }
}

TEST_CASE("the same worlds from every compiler") {
  std::uint64_t hash = 0;
  Workers workers(2);
  for (const FamilyName& family : families()) {
    const World world = make_world(
        family.family, {.width_px = 64, .height_px = 64, .duration_s = 4, .library = test_library()}, 5);
    for (const Sample& sample : draw_samples(world, 5, 4, 1, workers)) {
      for (const std::byte byte : sample_bytes(sample))
        hash = mix_bits(hash ^ static_cast<std::uint64_t>(byte));
    }
  }
  INFO("hash " << std::hex << hash);
  CHECK(hash == 0x4fae0192a17fdbe5u);
}
