#include <utility>

#include "citysim/scenes.hpp"
#include "citysim/things.hpp"

namespace egofocus::citysim {
namespace {

/// Inner side of a wall from a to b (seen from inside, a is to the left), `height` high.
void add_wall(Mesh& mesh, const Vec3& a, const Vec3& b, double height, const Surface& surface) {
  mesh.quad(a, b, b + Vec3{0, 0, height}, a + Vec3{0, 0, height}, surface);
}

/// A picture, window or board on a wall; `place` has x along the wall to the right seen from inside, y into
/// the room.
void add_panel(Mesh& mesh, const Place& place, double width, double height, const Surface& surface) {
  const auto p = [&](double x, double z) { return place.point(x, 0.02, z); };
  mesh.quad(p(-0.5 * width, 0), p(0.5 * width, 0), p(0.5 * width, height), p(-0.5 * width, height), surface);
}

}  // namespace

Scene make_room(std::shared_ptr<const TextureLibrary> shared, std::uint64_t seed) {
  Random random(seed, "room");
  Scene scene;
  scene.library = std::move(shared);
  const TextureLibrary& library = *scene.library;
  const double half_x = 0.5 * random.log_uniform(2.6, 12.0);
  const double half_y = 0.5 * random.log_uniform(2.6, 9.0);
  const double height = random.uniform(2.3, 4.0);
  const double blank = random.uniform(0.1, 0.8);  // of walls
  Mesh mesh;

  const Vec3 corners[4] = {
      {-half_x, -half_y, 0}, {half_x, -half_y, 0}, {half_x, half_y, 0}, {-half_x, half_y, 0}};
  const Surface floor =
      random.chance(0.4) ? library.surface(Pattern::kPlanks, 1.5, random) : library.any(2.0, 0.3, random);
  mesh.quad(corners[0], corners[1], corners[2], corners[3], floor);
  const Vec3 up{0, 0, height};
  mesh.quad(corners[3] + up, corners[2] + up, corners[1] + up, corners[0] + up,
            library.any(2.0, 0.8, random));
  for (std::size_t i = 0; i < 4; ++i) {
    // Seen from inside with the room's corners counter-clockwise, the left end of a wall is the later corner.
    const Vec3& a = corners[(i + 1) % 4];
    const Vec3& b = corners[i];
    add_wall(mesh, a, b, height, library.any(3.0, blank, random));
    const Vec3 along = b - a;
    const double length = square_root(dot(along, along));
    const Vec3 x = (1.0 / length) * along;
    const Place wall{a, x, cross(x, {0, 0, 1}), {0, 0, 1}};
    // What hangs on it, from left to right.
    for (double at = random.uniform(0.3, 1.2); at < length - 0.6;) {
      const double width = random.uniform(0.4, 1.8);
      if (at + width > length - 0.2) break;
      if (random.chance(0.6)) {
        Surface panel = library.any(1.2, 0.1, random);
        if (random.chance(0.3)) panel = library.surface(Pattern::kFacade, 1.8, random);
        if (random.chance(0.12)) panel.emission = 0.8f;  // a window or screen
        add_panel(mesh, wall.at(at + 0.5 * width, 0, random.uniform(0.7, 1.3)), width,
                  random.uniform(0.4, 1.2), panel);
      }
      at += width + random.uniform(0.2, 1.5);
    }
    scene.ways.sights.push_back(0.5 * (a + b) + Vec3{0, 0, 1.2});
  }
  scene.objects.push_back(mesh.take());

  // Furniture along the walls and, in large rooms, in the middle. What is kept free is a ring or the middle.
  const double margin = 0.75;
  const auto put = [&](const Vec3& at, double angle) {
    const Place place = Place{at, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}.turned(angle);
    switch (random.below(5)) {
      case 0:
        add_shelf(mesh, place, random.uniform(0.6, 1.2), random.uniform(0.9, height - 0.2), library, random);
        break;
      case 1: {
        const double high = random.uniform(0.5, 0.95);
        add_table(mesh, place.at(0, 0.35, 0), random.uniform(0.8, 1.3), 0.65, high, library, random);
        for (int i = 0; i < 3; ++i) {
          add_clutter(mesh, place.at(random.uniform(-0.4, 0.4), random.uniform(0.15, 0.5), high),
                      random.uniform(0.1, 0.3), library, random);
        }
        break;
      }
      case 2:
        add_chair(mesh, place.at(0, 0.35, 0), library, random);
        break;
      case 3:
        add_clutter(mesh, place.at(0, 0.4, 0), random.uniform(0.4, 0.8), library, random);
        break;
      default:
        add_bush(mesh, place.at(0, 0.4, 0), library, random);
        break;
    }
    scene.ways.sights.push_back(at + Vec3{0, 0, random.uniform(0.4, 1.3)});
    scene.objects.push_back(mesh.take());
  };
  for (double x = -half_x + 0.7; x < half_x - 0.6; x += random.uniform(0.9, 2.0)) {
    if (random.chance(0.6)) put({x, -half_y, 0}, 0);
    if (random.chance(0.6)) put({x, half_y, 0}, 3.141592653589793);
  }
  for (double y = -half_y + 1.3; y < half_y - 1.2; y += random.uniform(0.9, 2.0)) {
    if (random.chance(0.5)) put({-half_x, y, 0}, -1.5707963267948966);
    if (random.chance(0.5)) put({half_x, y, 0}, 1.5707963267948966);
  }
  const double x = half_x - margin - 0.15;
  const double y = half_y - margin - 0.15;
  const double low = 0.25;
  const double high = height - 0.3;
  if (x > 2.4 && y > 1.4 && random.chance(0.7)) {
    // An island in the middle, and the way around it.
    const double in = 0.8;
    add_table(mesh, Place{}, 2 * in, 2 * in - 0.4, random.uniform(0.6, 0.9), library, random);
    for (int i = 0; i < 5; ++i) {
      add_clutter(mesh, Place{}.at(random.uniform(-0.6, 0.6), random.uniform(-0.4, 0.4), 0.75),
                  random.uniform(0.15, 0.6), library, random);
    }
    scene.objects.push_back(mesh.take());
    scene.ways.sights.push_back({0, 0, 0.9});
    const double free = in + 0.35;
    scene.ways.boxes = {{{-x, -y, low}, {-free, y, high}},
                        {{-x, free, low}, {x, y, high}},
                        {{free, -y, low}, {x, y, high}},
                        {{-x, -y, low}, {x, -free, high}}};
  } else {
    scene.ways.boxes = {{{-x, -y, low}, {x, y, high}}};
  }
  if (scene.ways.boxes.size() == 1 && (x < 0.3 || y < 0.3)) {  // a closet: stand in the middle
    scene.ways.boxes = {{{-0.3, -0.3, 1.0}, {0.3, 0.3, 1.5}}};
  }
  for (int i = 0; i < 2; ++i) {
    scene.lamps.push_back(
        {{random.uniform(-0.6, 0.6) * half_x, random.uniform(-0.6, 0.6) * half_y, height - 0.3},
         random.log_uniform(0.1, 1.5),
         random.chance(0.5)});
  }
  scene.flicker_depth = random.chance(0.4) ? random.uniform(0.02, 0.2) : 0.0;
  scene.sky.indoors = true;
  scene.sky.sun = 0;
  scene.sky.ambient = random.log_uniform(0.05, 0.6);
  finish_scene(scene);
  return scene;
}

Scene make_desk(std::shared_ptr<const TextureLibrary> shared, std::uint64_t seed) {
  Random random(seed, "desk");
  Scene scene;
  scene.library = std::move(shared);
  const TextureLibrary& library = *scene.library;
  Mesh mesh;
  // The camera looks along x over a table whose top is z = 0; things stand between 0.35 and 2 m away.
  const double wall_m = random.uniform(1.0, 3.2);
  const double half = 1.6 + wall_m;
  const Surface top =
      random.chance(0.5) ? library.surface(Pattern::kPlanks, 0.8, random) : library.any(0.6, 0.35, random);
  mesh.quad({-0.6, -half, 0}, {wall_m - random.uniform(0, 0.3), -half, 0}, {wall_m, half, 0}, {-0.6, half, 0},
            top);
  mesh.quad({wall_m, half, -1}, {wall_m, -half, -1}, {wall_m, -half, 2.5}, {wall_m, half, 2.5},
            library.any(1.2, 0.45, random));
  mesh.quad({wall_m, -half, -1}, {-2, -half, -1}, {-2, -half, 2.5}, {wall_m, -half, 2.5},
            library.any(1.5, 0.5, random));
  mesh.quad({-2, half, -1}, {wall_m, half, -1}, {wall_m, half, 2.5}, {-2, half, 2.5},
            library.any(1.5, 0.5, random));
  mesh.quad({-2, half, 2.5}, {wall_m, half, 2.5}, {wall_m, -half, 2.5}, {-2, -half, 2.5},
            library.any(2.0, 0.8, random));
  mesh.quad({-2, -half, -1}, {wall_m, -half, -1}, {wall_m, half, -1}, {-2, half, -1},
            library.any(2.0, 0.5, random));
  scene.objects.push_back(mesh.take());
  const int posters = static_cast<int>(random.below(5));
  for (int i = 0; i < posters; ++i) {
    const double y = random.uniform(-0.6, 0.6) * half;
    const Place place{{wall_m, y, random.uniform(0.0, 0.9)}, {0, -1, 0}, {-1, 0, 0}, {0, 0, 1}};
    add_panel(mesh, place, random.uniform(0.2, 0.9), random.uniform(0.2, 0.8), library.any(0.6, 0.1, random));
  }
  const int things = 5 + static_cast<int>(random.below(12));
  for (int i = 0; i < things; ++i) {
    const double x = 0.4 + (wall_m - 0.5) * random.uniform() * random.uniform(0.5, 1.0);
    const double y = random.uniform(-0.65, 0.65) * (0.35 + x);
    const Place place = Place{{x, y, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}.turned(random.uniform(0, 6.28));
    const double size = random.log_uniform(0.07, 0.4) * (0.5 + 0.5 * x);
    if (random.chance(0.1)) {
      add_bush(mesh, place, library, random);
    } else {
      add_clutter(mesh, place, size, library, random);
    }
    if (!mesh.empty()) scene.objects.push_back(mesh.take());
    scene.ways.sights.push_back({x, y, 0.5 * size});
  }
  scene.ways.sights.push_back({wall_m, 0, 0.4});
  scene.ways.boxes = {{{-0.35, -0.45, 0.12}, {0.1, 0.45, 0.7}}};
  scene.lamps.push_back({{random.uniform(-0.5, 1.0), random.uniform(-1, 1), random.uniform(1.0, 2.2)},
                         random.log_uniform(0.1, 1.5),
                         random.chance(0.5)});
  scene.flicker_depth = random.chance(0.4) ? random.uniform(0.02, 0.2) : 0.0;
  scene.sky.indoors = true;
  scene.sky.sun = 0;
  scene.sky.ambient = random.log_uniform(0.08, 0.7);
  finish_scene(scene);
  return scene;
}

}  // namespace egofocus::citysim
