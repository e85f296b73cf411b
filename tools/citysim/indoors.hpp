// What rooms, desks and corridors share: walls, what hangs on them, and their light.
#pragma once

#include "citysim/mesh.hpp"
#include "citysim/scene.hpp"
#include "citysim/texture_library.hpp"

namespace egofocus::citysim {

/// Inner side of a wall from a to b (seen from inside, a is to the left), which are on the floor.
void add_wall(Mesh& mesh, const Vec3& a, const Vec3& b, double height_a, double height_b,
              const Surface& surface);

/// A picture or board on a wall, or a window; `place` has x along the wall to the right seen from inside, y
/// into the room. Centred in x.
void add_panel(Mesh& mesh, const Place& place, double width, double height, const Surface& surface);

/// What hangs on a wall: boards, pictures, some windows and screens that shine.
[[nodiscard]] Surface panel_surface(const TextureLibrary& library, Random& random);

/// The end of an indoor scene, after all objects and lamps: light from everywhere between the two bounds,
/// perhaps flicker of the lamps; calls finish_scene().
void light_indoors(Scene& scene, double least_ambient, double most_ambient, Random& random);

}  // namespace egofocus::citysim
