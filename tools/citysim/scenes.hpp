// The families of scenes. Everything in them is drawn from the seed; the way that the robot goes is free.
#pragma once

#include <memory>

#include "citysim/scene.hpp"
#include "citysim/texture_library.hpp"

namespace egofocus::citysim {

/// What tells one town from another. Shares and densities are 0..1.
struct TownStyle {
  bool night = false;
  double block_m = 70;         ///< mean distance between streets
  double street_half_m = 5.4;  ///< half a street's width without pavements
  double pavement_m = 2.5;
  double houses = 0.85;  ///< share of the street fronts that are built up
  double trees = 0.4;
  double parked = 0.4;
  double traffic = 0.4;
  double people = 0.4;
  double clutter = 0.4;
  double slope = 0.03;  ///< largest of the whole town
  double lamp_m = 28;   ///< distance between lamp posts
};

struct TownWay {
  double length_m = 800;     ///< at least so long is the route
  bool on_pavement = false;  ///< small robots; otherwise the right-hand lane
};

Scene make_town(const TownStyle& style, const TownWay& way, std::shared_ptr<const TextureLibrary> library,
                std::uint64_t seed);
Scene make_room(std::shared_ptr<const TextureLibrary> library, std::uint64_t seed);
Scene make_desk(std::shared_ptr<const TextureLibrary> library, std::uint64_t seed);
/// The route is at least `length_m` long.
Scene make_corridor(double length_m, std::shared_ptr<const TextureLibrary> library, std::uint64_t seed);

}  // namespace egofocus::citysim
