// One recording's world: scene, motion, camera, sensor, all drawn from a family's name and a seed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "citysim/dvs.hpp"
#include "citysim/motion_bus.hpp"
#include "citysim/scenes.hpp"
#include "citysim/trajectory.hpp"
#include "egofocus/config.hpp"

namespace egofocus::citysim {

enum class Family : std::uint8_t {
  kTown1,
  kTown2Night,
  kTown3,
  kTown4,
  kTown5Night,
  kRoom,
  kDesk,
  kCorridor,
};

struct FamilyName {
  std::string_view name;
  Family family;
  std::string_view about;
};
/// In the order of the enumerators.
[[nodiscard]] std::span<const FamilyName> families();
[[nodiscard]] std::optional<Family> family_of(std::string_view name);
[[nodiscard]] std::string_view name_of(Family family);

struct WorldOptions {
  int width_px = 346;
  int height_px = 260;
  double duration_s = 10;
  bool clean_sensor = false;
  std::shared_ptr<const TextureLibrary> library;  ///< none: made from the seed
};

struct World {
  Family family{};
  bool night = false;
  Scene scene;
  Trajectory trajectory;  ///< of the body
  Mount mount;
  CameraModel camera;  ///< the sensor's, distorted
  Intrinsics grid;     ///< undistorted, on which depth and pictures lie
  double blur = 0;     ///< of the lens (Renderer)
  DvsParameters sensor;
  BusRobot robot{};
  double z_near_m = 2;  ///< [ladder] of its camera.toml: what is nearer is 0.5 to 6 % of all along the way
  double depth_scale_m = 1.0 / 256;

  [[nodiscard]] RigidState camera_at(double t_s) const { return camera_on(trajectory.body_at(t_s), mount); }
};

/// Throws std::invalid_argument for a size outside 64..1280 or a duration outside (0, 1000] s.
[[nodiscard]] World make_world(Family family, const WorldOptions& options, std::uint64_t seed);

}  // namespace egofocus::citysim
