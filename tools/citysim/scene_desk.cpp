#include <algorithm>
#include <utility>

#include "citysim/indoors.hpp"
#include "citysim/scenes.hpp"
#include "citysim/things.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kQuarter = 1.5707963267948966;
constexpr double kFloor_m = -0.75;  // the table's top is z = 0
constexpr double kFree_m = 0.2;     // between the camera's box and what stands on the table
// The camera's, which looks along x.
constexpr FreeBox kBox{{-0.5, -0.65, 0.12}, {-0.05, 0.65, 0.6}};

/// The room around the table: x to the wall behind it, which mostly is not square to the camera.
void add_room(Mesh& mesh, const Place& room, double wall_m, double half, const TextureLibrary& library,
              Random& random) {
  const double back = -2.0;
  const double height = random.uniform(2.0, 3.0);
  const auto p = [&](double x, double y, double z) { return room.point(x, y, z); };
  const double rise = height - kFloor_m;
  const Vec3 corners[4] = {p(back, -half, kFloor_m), p(wall_m, -half, kFloor_m), p(wall_m, half, kFloor_m),
                           p(back, half, kFloor_m)};
  for (std::size_t i = 0; i < 4; ++i) {
    const double blank = i == 1 ? 0.45 : 0.6;
    add_wall(mesh, corners[(i + 1) % 4], corners[i], rise, rise,
             library.any(random.log_uniform(0.8, 2.5), blank, random));
  }
  const Vec3 up{0, 0, rise};
  mesh.quad(corners[3] + up, corners[2] + up, corners[1] + up, corners[0] + up,
            library.any(2.0, 0.8, random));
  mesh.quad(corners[0], corners[1], corners[2], corners[3], library.any(2.0, 0.4, random));
  const int panels = static_cast<int>(random.below(6));
  for (int i = 0; i < panels; ++i) {
    const double above = random.uniform(-0.2, 1.0);
    const double aside = random.uniform(-0.7, 0.7) * half;
    const Place at{p(wall_m, aside, above), -1.0 * room.y, -1.0 * room.x, {0, 0, 1}};
    const Surface surface = panel_surface(library, random);
    const double tall = random.log_uniform(0.15, 0.8);
    const double wide = random.log_uniform(0.15, 0.9);
    add_panel(mesh, at, wide, tall, surface);
  }
}

/// One thing of about `size`, seen against x.
void add_thing(Mesh& mesh, const Place& place, double size, const TextureLibrary& library, Random& random) {
  const double dice = random.uniform();
  const Place turned = place.turned(random.uniform(-3.1, 3.1));
  if (dice < 0.08) {
    add_plant(mesh, place, 1.3 * size, library, random);
  } else if (dice < 0.2 && size > 0.12) {
    add_screen(mesh, place.turned(kQuarter + random.uniform(-0.6, 0.6)), 1.3 * size, library, random);
  } else if (dice < 0.32) {
    const Surface slope = library.any(size, 0.4, random);
    const Surface sides = library.any(size, 0.6, random);
    const double high = size * random.uniform(0.15, 0.7);
    add_wedge(mesh, turned, 1.2 * size, size, high, slope, sides);
  } else {
    add_clutter(mesh, turned, size, library, random);
  }
}

}  // namespace

Scene make_desk(std::shared_ptr<const TextureLibrary> shared, std::uint64_t seed) {
  Random random(seed, "desk");
  Scene scene;
  scene.library = std::move(shared);
  const TextureLibrary& library = *scene.library;
  Mesh mesh;
  const double wall_m = random.log_uniform(0.9, 3.0);
  const double half = 1.4 + wall_m;
  const double slant = random.chance(0.6) ? random.uniform(-0.6, 0.6) : random.uniform(-0.08, 0.08);
  const Place room = Place{}.turned(slant);
  add_room(mesh, room, wall_m, half, library, random);
  scene.objects.push_back(mesh.take());

  const Surface top =
      random.chance(0.4) ? library.surface(Pattern::kPlanks, 0.8, random) : library.any(0.6, 0.45, random);
  const double front = -0.7;
  const double length = wall_m - front - (random.chance(0.5) ? 0.02 : random.uniform(0.05, 0.5));
  const double width = random.uniform(1.2, 2 * half - 0.5);
  mesh.box(room.at(front + 0.5 * length, random.uniform(-0.2, 0.2), -0.05), length, width, 0.05, top, top,
           true);
  scene.objects.push_back(mesh.take());

  const int things = 8 + static_cast<int>(random.below(24));
  const double largest = random.uniform(0.25, 0.5);
  for (int i = 0; i < things; ++i) {
    const double size = random.log_uniform(0.04, largest);
    const double reach = 0.75 * size;
    const double nearest = kBox.high[0] + kFree_m + reach;
    const double farthest = front + length - reach;
    // The first few stand in front, so that nearly all desks have something near.
    const double depth = i < 5 ? random.uniform(0, 0.3) : random.uniform();
    const double x = nearest + depth * std::max(0.0, farthest - nearest);
    const double y = random.uniform(-0.8, 0.8) * std::min(0.4 + 0.7 * x, 0.5 * width);
    const Place place = Place{room.point(x, y, 0), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    if (place.origin[0] < nearest) continue;
    add_thing(mesh, place, size, library, random);
    scene.objects.push_back(mesh.take());
    scene.ways.sights.push_back(place.point(0, 0, 0.5 * size));
  }
  scene.ways.sights.push_back(room.point(wall_m, 0, 0.4));
  scene.ways.boxes = {kBox};
  scene.lamps.push_back({{random.uniform(-0.5, 0.8), random.uniform(-1, 1), random.uniform(1.0, 1.9)},
                         random.log_uniform(0.1, 1.5),
                         random.chance(0.5)});
  light_indoors(scene, 0.08, 0.7, random);
  return scene;
}

}  // namespace egofocus::citysim
