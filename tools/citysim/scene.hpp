// A scene: flat polygons with textures, in objects that stand or move rigidly, under lamps and a sky.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "citysim/texture.hpp"
#include "citysim/trajectory.hpp"
#include "citysim/vec3.hpp"
#include "citysim/ways.hpp"

namespace egofocus::citysim {

class TextureLibrary;

/// A value that changes linearly over a polygon: gradient . p + offset, p in the object's frame.
struct Affine {
  Vec3 gradient{0, 0, 0};
  double offset = 0;
};

using Colour = std::array<float, 3>;  ///< red, green, blue; reflectance or linear light

/// Convex and flat; corners counter-clockwise seen from the front. Only the front is seen.
struct Polygon {
  std::array<Vec3, 4> corners;
  int corner_count = 4;  ///< 3 or 4
  Vec3 normal{0, 0, 1};  ///< unit, to the front; set by finish_scene()
  int texture = 0;
  Colour colour{1, 1, 1};  ///< times the texture's reflectance
  Affine u;                ///< texture coordinates, in texels of the finest level
  Affine v;
  Affine steady;       ///< light that falls on it: sun, sky, steady lamps
  Affine flickering;   ///< light of mains lamps, modulated over time
  float emission = 0;  ///< own light, times the texture
};

/// Polygons that stand or move together. A mover goes from `from` along `velocity_m_s`, and again from `from`
/// after `period_s`; it is far from the camera's way when that happens, or hidden.
struct Object {
  std::vector<Polygon> polygons;
  Vec3 centre{0, 0, 0};  ///< bounding sphere, in the object's frame
  double radius_m = 0;
  bool moves = false;
  Pose start;  ///< movers only: object's frame to the world at phase 0
  Vec3 velocity_m_s{0, 0, 0};
  double period_s = 0;
  double phase_s = 0;

  /// Object's frame to the world.
  [[nodiscard]] Pose pose_at(double t_s) const;
};

/// A lamp that lights what is around it; baked into Polygon::steady and Polygon::flickering.
struct Lamp {
  Vec3 position;
  double strength = 1;  ///< light at 1 m, facing it
  bool mains = false;   ///< flickers
};

/// Light from far away.
struct Sky {
  double zenith = 1;
  double horizon = 1;
  double clouds = 0;     ///< share of the light that the cloud texture modulates
  int texture = -1;      ///< of the clouds; none below 0
  Vec3 to_sun{0, 0, 1};  ///< unit
  double sun = 1;        ///< light on a surface that faces the sun
  double ambient = 0.3;  ///< light from everywhere
  double haze_m = 0;     ///< depth at which half of the light is haze; 0: clear
  bool indoors = false;  ///< no sky is seen: what no polygon covers is dark
};

struct Scene {
  std::shared_ptr<const TextureLibrary> library;  ///< what Polygon::texture and Sky::texture index
  std::vector<Object> objects;
  std::vector<Lamp> lamps;
  Sky sky;
  double flicker_hz = 100;   ///< of lamps on the mains: twice the grid's frequency
  double flicker_depth = 0;  ///< 0 none .. 1 full
  double headlight = 0;      ///< light of the robot's own lamps on a surface at 1 m; 0: none
  Ways ways;

  [[nodiscard]] double flicker_at(double t_s) const;
};

/// Computes each object's bounding sphere, and the light on each polygon from sky and lamps. To be called
/// once, when all objects and lamps are there.
void finish_scene(Scene& scene);

}  // namespace egofocus::citysim
