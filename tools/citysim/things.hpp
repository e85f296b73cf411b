// Things that stand about: each builds on a place (x forward, y left, z up from the ground).
#pragma once

#include "citysim/mesh.hpp"
#include "citysim/texture_library.hpp"

namespace egofocus::citysim {

void add_car(Mesh& mesh, const Place& place, const TextureLibrary& library, bool lights_on, Random& random);
void add_person(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random);
void add_tree(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random);
void add_bush(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random);
/// A plate on a pole, facing against x.
void add_sign(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random);
/// Its lamp head is at the returned point, `reach` metres along x from the pole.
Vec3 add_lamp_post(Mesh& mesh, const Place& place, double height, double reach, bool lit,
                   const TextureLibrary& library, Random& random);
/// A box, bin, bench or crate of up to about a metre; some are blank.
void add_clutter(Mesh& mesh, const Place& place, double size, const TextureLibrary& library, Random& random);
/// A house on a footprint of length (along x) and width (along y, backwards from the street side y = 0).
/// `lit`: by night some windows and signs shine.
void add_house(Mesh& mesh, const Place& place, double length, double width, bool lit,
               const TextureLibrary& library, Random& random);
void add_table(Mesh& mesh, const Place& place, double length, double width, double height,
               const TextureLibrary& library, Random& random);
void add_chair(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random);
/// Its back stands at y = 0, its front looks along y.
void add_shelf(Mesh& mesh, const Place& place, double length, double height, const TextureLibrary& library,
               Random& random);
/// As a shelf, but closed; mostly blank.
void add_cupboard(Mesh& mesh, const Place& place, double length, double depth, double height,
                  const TextureLibrary& library, Random& random);
/// Its back stands at y = 0.
void add_sofa(Mesh& mesh, const Place& place, double length, const TextureLibrary& library, Random& random);
/// In a pot; `size` is its height.
void add_plant(Mesh& mesh, const Place& place, double size, const TextureLibrary& library, Random& random);
/// On a foot, looking along y; half of them are lit.
void add_screen(Mesh& mesh, const Place& place, double width, const TextureLibrary& library, Random& random);
/// A slope that rises along x, from the ground at -length / 2 to `height`.
void add_wedge(Mesh& mesh, const Place& place, double length, double width, double height,
               const Surface& slope, const Surface& sides);

}  // namespace egofocus::citysim
