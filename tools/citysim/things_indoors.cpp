#include "citysim/things.hpp"

namespace egofocus::citysim {

void add_table(Mesh& mesh, const Place& place, double length, double width, double height,
               const TextureLibrary& library, Random& random) {
  const Surface wood =
      random.chance(0.6) ? library.surface(Pattern::kPlanks, 1.0, random) : library.any(0.8, 0.5, random);
  mesh.box(place.at(0, 0, height - 0.04), length, width, 0.04, wood, wood, true);
  for (const double x : {-0.45, 0.45}) {
    for (const double y : {-0.45, 0.45})
      mesh.box(place.at(x * length, y * width, 0), 0.06, 0.06, height - 0.04, wood, wood);
  }
}

void add_chair(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random) {
  const Surface seat = library.any(0.5, 0.4, random);
  add_table(mesh, place, 0.44, 0.44, 0.46, library, random);
  mesh.box(place.at(-0.2, 0, 0.46), 0.05, 0.42, 0.45, seat, seat);
}

void add_shelf(Mesh& mesh, const Place& place, double length, double height, const TextureLibrary& library,
               Random& random) {
  const Surface frame = library.any(1.0, 0.5, random);
  mesh.box(place.at(0, 0.14, 0), length, 0.28, height, frame, frame);
  const Surface books = library.surface(Pattern::kBooks, 1.3, random);
  const double l = 0.47 * length;
  mesh.quad(place.point(l, 0.285, 0.1), place.point(-l, 0.285, 0.1), place.point(-l, 0.285, height - 0.1),
            place.point(l, 0.285, height - 0.1), books);
}

void add_cupboard(Mesh& mesh, const Place& place, double length, double depth, double height,
                  const TextureLibrary& library, Random& random) {
  const Surface sides = library.any(1.2, 0.7, random);
  const Surface front = random.chance(0.5) ? sides : library.any(1.2, 0.6, random);
  mesh.box(place.at(0, 0.5 * depth, 0), length, depth, height, sides, sides);
  const auto p = [&](double x, double z) { return place.point(x, depth + 0.005, z); };
  const double l = 0.5 * length - 0.02;
  mesh.quad(p(l, 0.05), p(-l, 0.05), p(-l, height - 0.03), p(l, height - 0.03), front);
}

void add_sofa(Mesh& mesh, const Place& place, double length, const TextureLibrary& library, Random& random) {
  const Surface cloth = library.any(1.5, 0.6, random);
  const double seat = random.uniform(0.38, 0.48);
  mesh.box(place.at(0, 0.45, 0), length, 0.8, seat, cloth, cloth);
  mesh.box(place.at(0, 0.14, seat), length, 0.25, random.uniform(0.3, 0.5), cloth, cloth);
  for (const double side : {-0.5, 0.5})
    mesh.box(place.at(side * (length - 0.15), 0.45, seat), 0.15, 0.8, 0.18, cloth, cloth);
  const int cushions = static_cast<int>(random.below(4));
  for (int i = 0; i < cushions; ++i) {
    const Surface cushion = library.any(0.5, 0.2, random);
    mesh.box(place.at(random.uniform(-0.35, 0.35) * length, 0.38, seat).turned(random.uniform(-0.3, 0.3)),
             0.42, 0.14, 0.38, cushion, cushion);
  }
}

void add_plant(Mesh& mesh, const Place& place, double size, const TextureLibrary& library, Random& random) {
  mesh.prism(place, 8, 0.16 * size, 0.35 * size, library.any(size, 0.6, random), 1.25);
  mesh.prism(place, 4, 0.02 * size, 0.8 * size, library.surface(Pattern::kNoise, 0.5, random));
  const Surface leaves = library.surface(Pattern::kFoliage, 1.2 * size, random);
  const int blobs = 1 + static_cast<int>(random.below(3));
  for (int i = 0; i < blobs; ++i) {
    const double up = size * random.uniform(0.45, 0.85);
    const double aside = random.uniform(-0.12, 0.12) * size;
    const Vec3 at = place.point(random.uniform(-0.12, 0.12) * size, aside, up);
    mesh.blob(at, size * random.uniform(0.15, 0.32), 0.3, leaves, random);
  }
}

void add_screen(Mesh& mesh, const Place& place, double width, const TextureLibrary& library, Random& random) {
  const Surface shell = library.surface(Pattern::kBlank, 1.0, random);
  const double height = width * random.uniform(0.5, 0.75);
  const double foot = width * random.uniform(0.1, 0.3);
  mesh.box(place, 0.35 * width, 0.25 * width, 0.02, shell, shell);
  mesh.box(place, 0.08 * width, 0.03, foot, shell, shell);
  mesh.box(place.at(0, 0, foot), width, 0.03, height, shell, shell, true);
  Surface face = library.any(0.7 * width, 0.45, random);
  if (random.chance(0.5)) face.emission = static_cast<float>(random.log_uniform(0.1, 0.8));
  const auto p = [&](double x, double z) { return place.point(x * width, 0.017, foot + z * height); };
  mesh.quad(p(0.47, 0.06), p(-0.47, 0.06), p(-0.47, 0.95), p(0.47, 0.95), face);
}

void add_wedge(Mesh& mesh, const Place& place, double length, double width, double height,
               const Surface& slope, const Surface& sides) {
  const double l = 0.5 * length;
  const double w = 0.5 * width;
  const auto p = [&](double x, double y, double z) { return place.point(x, y, z); };
  mesh.quad(p(-l, -w, 0), p(l, -w, height), p(l, w, height), p(-l, w, 0), slope);
  mesh.quad(p(l, -w, 0), p(l, w, 0), p(l, w, height), p(l, -w, height), sides);
  mesh.triangle(p(-l, -w, 0), p(l, -w, 0), p(l, -w, height), {0, 0}, {length, 0}, {length, height}, sides);
  mesh.triangle(p(l, w, 0), p(-l, w, 0), p(l, w, height), {0, 0}, {length, 0}, {0, height}, sides);
}

}  // namespace egofocus::citysim
