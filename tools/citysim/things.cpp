#include "citysim/things.hpp"

namespace egofocus::citysim {
namespace {

Surface paint(const TextureLibrary& library, Random& random) {
  Surface surface = library.surface(random.chance(0.75) ? Pattern::kBlank : Pattern::kStripes, 2.0, random);
  const double value = random.log_uniform(0.15, 1.3);
  for (float& channel : surface.colour) channel = static_cast<float>(value * random.uniform(0.5, 1.2));
  return surface;
}

Surface dark(const TextureLibrary& library, double value, Random& random) {
  Surface surface = library.surface(Pattern::kBlank, 1.0, random);
  for (float& channel : surface.colour) channel = static_cast<float>(value);
  return surface;
}

/// Some windows of the front, from behind which light comes through curtains.
void light_windows(Mesh& mesh, const Place& place, double length, double height, double storey,
                   const TextureLibrary& library, Random& random) {
  const double awake = random.uniform(0.05, 0.4);
  for (double z = 0.8 + 0.35 * storey; z + 1.3 < height; z += storey) {
    for (double x = -0.5 * length + 1.2; x < 0.5 * length - 1.0; x += random.uniform(1.6, 3.5)) {
      if (!random.chance(awake)) continue;
      Surface window = library.any(1.2, 0.3, random);
      window.emission = static_cast<float>(random.log_uniform(0.05, 0.6));
      const double half = random.uniform(0.35, 0.7);
      const double high = z + random.uniform(0.9, 1.4);
      const auto p = [&](double right, double up) { return place.point(right, 0.03, up); };
      mesh.quad(p(x + half, z), p(x - half, z), p(x - half, high), p(x + half, high), window);
    }
  }
}

}  // namespace

void add_car(Mesh& mesh, const Place& place, const TextureLibrary& library, bool lights_on, Random& random) {
  const double length = random.uniform(3.6, 5.2);
  const double width = random.uniform(1.6, 1.95);
  const bool van = random.chance(0.2);
  const double belt = random.uniform(0.85, 1.05);
  const double roof = van ? random.uniform(1.9, 2.5) : random.uniform(1.38, 1.6);
  const Surface body = paint(library, random);
  const Surface glass = dark(library, 0.12, random);
  const Surface tyre = dark(library, 0.08, random);
  mesh.box(place.at(0, 0, 0.28), length, width, belt - 0.28, body, body);
  // Cabin: sloped at both ends.
  const double back = -0.46 * length;
  const double front = van ? 0.4 * length : 0.2 * length;
  const double slope = van ? 0.15 : 0.45;
  const double w = 0.46 * width;
  const auto p = [&](double x, double y, double z) { return place.point(x, y, z); };
  const Vec3 a0 = p(back, -w, belt), a1 = p(front, -w, belt), a2 = p(front - slope, -w, roof),
             a3 = p(back + slope, -w, roof);
  const Vec3 b0 = p(back, w, belt), b1 = p(front, w, belt), b2 = p(front - slope, w, roof),
             b3 = p(back + slope, w, roof);
  mesh.quad(a0, a1, a2, a3, glass);
  mesh.quad(b1, b0, b3, b2, glass);
  mesh.quad(a1, b1, b2, a2, glass);
  mesh.quad(b0, a0, a3, b3, glass);
  mesh.quad(a3, a2, b2, b3, body);
  for (const double x : {-0.3, 0.3}) {
    for (const double side : {-1.0, 1.0})
      mesh.box(place.at(x * length, side * 0.46 * width, 0), 0.6, 0.2, 0.55, tyre, tyre);
  }
  Surface lamp = library.surface(Pattern::kBlank, 1.0, random);
  lamp.emission = lights_on ? 6.0f : 0.0f;
  Surface tail = lamp;
  tail.colour = {0.9f, 0.1f, 0.1f};
  tail.emission = lights_on ? 1.5f : 0.0f;
  for (const double side : {-0.36, 0.36}) {
    const double y = side * width;
    const double x = 0.5 * length + 0.01;
    mesh.quad(p(x, y - 0.14, 0.55), p(x, y + 0.14, 0.55), p(x, y + 0.14, 0.72), p(x, y - 0.14, 0.72), lamp);
    mesh.quad(p(-x, y + 0.14, 0.6), p(-x, y - 0.14, 0.6), p(-x, y - 0.14, 0.78), p(-x, y + 0.14, 0.78), tail);
  }
  const Surface plate = library.surface(Pattern::kText, 0.7, random);
  mesh.quad(p(-0.5 * length - 0.01, 0.25, 0.4), p(-0.5 * length - 0.01, -0.25, 0.4),
            p(-0.5 * length - 0.01, -0.25, 0.52), p(-0.5 * length - 0.01, 0.25, 0.52), plate);
}

void add_person(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random) {
  const double size = random.uniform(0.88, 1.08);
  const Surface trousers = paint(library, random);
  const Surface coat = library.any(0.8, 0.4, random);
  const Surface skin = library.surface(Pattern::kBlank, 1.0, random);
  const double stride = random.uniform(0.0, 0.25);
  mesh.box(place.at(stride, 0.1, 0), 0.16, 0.15, 0.85 * size, trousers, trousers);
  mesh.box(place.at(-stride, -0.1, 0), 0.16, 0.15, 0.85 * size, trousers, trousers);
  mesh.box(place.at(0, 0, 0.82 * size), 0.24, 0.44, 0.6 * size, coat, coat);
  mesh.box(place.at(-stride, 0.28, 0.85 * size), 0.12, 0.1, 0.55 * size, coat, coat);
  mesh.box(place.at(stride, -0.28, 0.85 * size), 0.12, 0.1, 0.55 * size, coat, coat);
  mesh.prism(place.at(0, 0, 1.45 * size), 6, 0.11, 0.26, skin);
}

void add_tree(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random) {
  const double height = random.uniform(1.6, 3.2);
  const Surface bark = library.surface(Pattern::kNoise, 0.8, random);
  mesh.prism(place, 6, random.uniform(0.09, 0.25), height + 0.6, bark, 0.7);
  const Surface leaves = library.surface(Pattern::kFoliage, 3.0, random);
  const double radius = random.uniform(1.0, 2.2);
  const int blobs = 2 + static_cast<int>(random.below(3));
  for (int i = 0; i < blobs; ++i) {
    const double up = height + random.uniform(0.4, 1.3) * radius;
    const double aside = random.uniform(-0.6, 0.6) * radius;
    const double ahead = random.uniform(-0.6, 0.6) * radius;
    const Vec3 at = place.point(ahead, aside, up);
    mesh.blob(at, radius * random.uniform(0.6, 1.0), 0.25, leaves, random);
  }
}

void add_bush(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random) {
  const double radius = random.uniform(0.3, 0.9);
  mesh.blob(place.point(0, 0, 0.7 * radius), radius, 0.25, library.surface(Pattern::kFoliage, 2.0, random),
            random);
}

void add_sign(Mesh& mesh, const Place& place, const TextureLibrary& library, Random& random) {
  const double height = random.uniform(1.6, 2.8);
  const double half = random.uniform(0.25, 0.6);
  const Surface pole = dark(library, 0.5, random);
  mesh.prism(place, 4, 0.04, height + half, pole);
  const Surface face = random.chance(0.7) ? library.surface(Pattern::kText, 1.4 * half, random)
                                          : library.surface(Pattern::kStripes, half, random);
  const auto p = [&](double y, double z) { return place.point(-0.05, y, z); };
  mesh.quad(p(half, height - half), p(-half, height - half), p(-half, height + half), p(half, height + half),
            face);
  const auto q = [&](double y, double z) { return place.point(-0.045, y, z); };
  mesh.quad(q(-half, height - half), q(half, height - half), q(half, height + half), q(-half, height + half),
            pole);
}

Vec3 add_lamp_post(Mesh& mesh, const Place& place, double height, double reach, bool lit,
                   const TextureLibrary& library, Random& random) {
  const Surface metal = dark(library, random.uniform(0.1, 0.6), random);
  mesh.prism(place, 5, 0.09, height, metal, 0.7);
  mesh.box(place.at(0.5 * reach, 0, height - 0.1), reach, 0.1, 0.1, metal, metal, true);
  Surface head = library.surface(Pattern::kBlank, 1.0, random);
  head.emission = lit ? 8.0f : 0.0f;
  mesh.box(place.at(reach, 0, height - 0.22), 0.6, 0.25, 0.12, head, metal, true);
  return place.point(reach, 0, height - 0.4);
}

void add_clutter(Mesh& mesh, const Place& place, double size, const TextureLibrary& library, Random& random) {
  const Surface sides = library.any(size * random.uniform(0.8, 2.0), 0.3, random);
  const Surface top = library.any(size, 0.5, random);
  switch (random.below(3)) {
    case 0: {
      const double taper = random.uniform(0.7, 1.15);
      const double high = size * random.uniform(0.5, 1.6);
      const double radius = 0.5 * size * random.uniform(0.4, 1.0);
      mesh.prism(place, 5 + static_cast<int>(random.below(5)), radius, high, sides, taper);
      break;
    }
    case 1: {
      Place on = place;
      const int boxes = 1 + static_cast<int>(random.below(3));
      double side = size;
      for (int i = 0; i < boxes; ++i) {  // a stack
        const double height = size * random.uniform(0.15, 0.5);
        const Surface other = library.any(size * random.uniform(0.5, 1.5), 0.25, random);
        const double other_side = side * random.uniform(0.6, 1.0);
        mesh.box(on.turned(random.uniform(-0.3, 0.3)), side, other_side, height, other, other);
        on = on.at(0, 0, height);
        side *= random.uniform(0.7, 0.95);
      }
      break;
    }
    default: {
      const double high = size * random.uniform(0.3, 1.3);
      const double deep = size * random.uniform(0.4, 0.9);
      mesh.box(place, size * random.uniform(0.5, 1.4), deep, high, sides, top);
    }
  }
}

void add_house(Mesh& mesh, const Place& place, double length, double width, bool lit,
               const TextureLibrary& library, Random& random) {
  const double storey = random.uniform(2.7, 3.6);
  const double height = storey * (1.0 + static_cast<double>(random.below(6)));
  const bool blank = random.chance(0.15);
  const Surface front =
      blank ? library.any(6.0, 0.6, random) : library.surface(Pattern::kFacade, 2.6 * storey, random);
  Surface wall =
      random.chance(0.5) ? library.surface(Pattern::kBricks, 2.5, random) : library.any(5.0, 0.45, random);
  const Surface roof = library.any(3.0, 0.3, random);
  const double l = 0.5 * length;
  const auto p = [&](double x, double y, double z) { return place.point(x, y, z); };
  mesh.quad(p(l, 0, 0), p(-l, 0, 0), p(-l, 0, height), p(l, 0, height), front, {random.uniform(0, 8), 0});
  mesh.quad(p(-l, -width, 0), p(l, -width, 0), p(l, -width, height), p(-l, -width, height), wall);
  mesh.quad(p(-l, 0, 0), p(-l, -width, 0), p(-l, -width, height), p(-l, 0, height), wall);
  mesh.quad(p(l, -width, 0), p(l, 0, 0), p(l, 0, height), p(l, -width, height), wall, {3, 0});
  if (height < 3.2 * storey && random.chance(0.7)) {
    const double ridge = height + random.uniform(0.25, 0.5) * width;
    const double m = -0.5 * width;
    mesh.quad(p(l, 0.3, height - 0.1), p(-l, 0.3, height - 0.1), p(-l, m, ridge), p(l, m, ridge), roof);
    mesh.quad(p(-l, -width - 0.3, height - 0.1), p(l, -width - 0.3, height - 0.1), p(l, m, ridge),
              p(-l, m, ridge), roof);
    mesh.triangle(p(-l, 0, height), p(-l, -width, height), p(-l, m, ridge), {0, 0}, {width, 0},
                  {-m, ridge - height}, wall);
    mesh.triangle(p(l, -width, height), p(l, 0, height), p(l, m, ridge), {0, 0}, {width, 0},
                  {-m, ridge - height}, wall);
  } else {
    mesh.quad(p(-l, -width, height), p(l, -width, height), p(l, 0, height), p(-l, 0, height), roof);
  }
  if (random.chance(0.5)) {  // a door and a shop sign
    const double x = random.uniform(-0.6, 0.6) * l;
    mesh.box(place.at(x, 0.06, 0), 1.1, 0.14, 2.2, library.any(1.2, 0.4, random), roof);
    Surface sign = library.surface(Pattern::kText, 2.5, random);
    if (lit && random.chance(0.6)) sign.emission = static_cast<float>(random.log_uniform(0.1, 0.8));
    const double s = 0.6 * random.uniform(0.5, 1.0) * l;
    mesh.box(place.at(random.uniform(-0.3, 0.3) * l, 0.15, storey - 0.5), 2 * s, 0.3, 0.6, sign, sign, true);
  }
  if (lit) light_windows(mesh, place, length, height, storey, library, random);
  if (random.chance(0.35)) {  // balconies
    for (double z = storey; z + 1.2 < height; z += storey) {
      mesh.box(place.at(random.uniform(-0.4, 0.4) * l, 0.5, z), 0.3 * length, 1.0, 1.0, wall, wall, true);
    }
  }
}

}  // namespace egofocus::citysim
