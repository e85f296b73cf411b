// Worlds that are small enough to know everything about.
#pragma once

#include "citysim/mesh.hpp"
#include "citysim/texture_library.hpp"
#include "citysim/world.hpp"

namespace egofocus::citysim {

/// One library for all tests: it takes a third of a second.
inline std::shared_ptr<const TextureLibrary> test_library() {
  static const auto library = std::make_shared<const TextureLibrary>(1);
  return library;
}

/// A body that stands, or moves straight with a constant velocity, looking along x.
inline Trajectory straight(const Vec3& velocity_m_s, double duration_s) {
  constexpr double kInterval_s = 0.05;
  std::vector<Trajectory::Control> controls;
  for (int i = -1; i <= static_cast<int>(duration_s / kInterval_s) + 3; ++i) {
    controls.push_back({(kInterval_s * i) * velocity_m_s, 0, 0, 0});
  }
  return Trajectory(std::move(controls), kInterval_s);
}

/// Looks along the body's x.
inline Mount ahead() {
  return {{{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}}, {0, 0, 0}};
}

inline CameraModel bent_camera() {
  CameraModel camera;
  camera.intrinsics = {173, 130, 113.0, 112.5, 87.2, 63.9};
  camera.distortion = Distortion::kPlumbBob;
  camera.coefficients[0] = -0.3;
  camera.coefficients[1] = 0.09;
  camera.coefficients[2] = 4e-4;
  camera.coefficients[3] = -3e-4;
  return camera;
}

/// Everything but the objects: lit evenly, a clean sensor, no blur.
inline World empty_world(const Vec3& velocity_m_s, double duration_s) {
  World world{.family = Family::kDesk,
              .scene = {},
              .trajectory = straight(velocity_m_s, duration_s),
              .mount = ahead(),
              .camera = bent_camera(),
              .grid = bent_camera().intrinsics,
              .sensor = {}};
  world.scene.library = test_library();
  world.scene.sky.indoors = true;
  world.scene.sky.sun = 0;
  world.scene.sky.ambient = 1;
  return world;
}

}  // namespace egofocus::citysim
