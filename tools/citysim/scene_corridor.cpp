#include <utility>

#include "citysim/indoors.hpp"
#include "citysim/scenes.hpp"
#include "citysim/things.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kQuarter = 1.5707963267948966;

/// Surfaces that all pieces of one building share.
struct Finish {
  Surface floor, ceiling, left, right, door;
  double skirting_m;
};

/// One straight piece: x along it, y to the left; walls at y = +-half, from x = 0 to `length`.
void add_piece(Mesh& mesh, const Place& at, double length, double half, double height, const Finish& finish,
               const TextureLibrary& library, Random& random) {
  const auto p = [&](double x, double y, double z) { return at.point(x, y, z); };
  for (double x = 0; x < length; x += 4.0) {  // short quads: light changes along the way
    const double e = x + 4.0 < length ? x + 4.0 : length;
    mesh.quad(p(x, -half, 0), p(e, -half, 0), p(e, half, 0), p(x, half, 0), finish.floor, {x, 0});
    mesh.quad(p(x, half, height), p(e, half, height), p(e, -half, height), p(x, -half, height),
              finish.ceiling, {x, 0});
    mesh.quad(p(x, half, 0), p(e, half, 0), p(e, half, height), p(x, half, height), finish.left, {x, 0});
    mesh.quad(p(e, -half, 0), p(x, -half, 0), p(x, -half, height), p(e, -half, height), finish.right,
              {-x, 0});
  }
  const double skirting = finish.skirting_m;
  for (const double side : {-1.0, 1.0}) {
    if (skirting > 0) {
      const double y = side * (half - 0.015);
      const double a = side > 0 ? 0.0 : length;
      mesh.quad(p(a, y, 0), p(length - a, y, 0), p(length - a, y, skirting), p(a, y, skirting), finish.door);
    }
    // A place on the wall: x along it as seen from inside, y into the corridor.
    for (double x = random.uniform(0.3, 1.5); x < length - 0.7; x += random.uniform(0.8, 3.0)) {
      const Place wall = Place{p(x, side * half, 0), at.x, at.y, at.z}.turned(side > 0 ? 2 * kQuarter : 0.0);
      switch (random.below(9)) {
        case 0:
          mesh.box(wall.at(0, 0.03, 0), 0.95, 0.1, 2.1, finish.door, finish.door);
          break;
        case 1: {
          const Surface notice = library.surface(Pattern::kText, 1.0, random);
          const double tall = random.uniform(0.3, 0.8);
          const double wide = random.uniform(0.3, 1.2);
          const double up = random.uniform(1.0, 1.5);
          mesh.box(wall.at(0, 0.01, up), wide, 0.04, tall, notice, notice, true);
          break;
        }
        case 2:
          mesh.box(wall.at(0, 0.1, 0), 0.35, 0.3, height, finish.left, finish.left);
          break;  // a pillar
        case 3:
          add_clutter(mesh, wall.at(0, 0.25, 0), random.uniform(0.25, 0.5), library, random);
          break;
        case 4:
          if (half > 0.9) add_shelf(mesh, wall, 0.9, random.uniform(0.8, 2.0), library, random);
          break;
        case 5: {
          const double tall = random.uniform(0.8, 2.0);
          const double wide = random.uniform(0.5, 1.2);
          add_cupboard(mesh, wall, wide, 0.35, tall, library, random);
          break;
        }
        case 6: {
          const Place seen{wall.point(0, 0, random.uniform(0.6, 1.2)), -1.0 * wall.x, wall.y, wall.z};
          const Surface surface = panel_surface(library, random);
          const double tall = random.uniform(0.4, 1.0);
          const double wide = random.log_uniform(0.3, 2.0);
          add_panel(mesh, seen, wide, tall, surface);
          break;
        }
        case 7:
          if (half > 1.3) {
            add_person(mesh, wall.at(0, 0.35, 0).turned(random.uniform(-3, 3)), library, random);
          } else {
            add_plant(mesh, wall.at(0, 0.2, 0), random.uniform(0.5, 1.2), library, random);
          }
          break;
        default:
          break;  // bare wall
      }
    }
  }
}

}  // namespace

Scene make_corridor(double length_m, std::shared_ptr<const TextureLibrary> shared, std::uint64_t seed) {
  Random random(seed, "corridor");
  Scene scene;
  scene.library = std::move(shared);
  const TextureLibrary& library = *scene.library;
  const double half = 0.5 * random.log_uniform(1.5, 3.8);
  const double height = random.uniform(2.2, 3.6);
  const double blank = random.uniform(0.1, 0.75);
  Finish finish{library.any(1.5, 0.2, random),   library.any(1.2, 0.6, random),
                library.any(2.0, blank, random), library.any(2.0, blank, random),
                library.any(1.0, 0.4, random),   random.chance(0.6) ? random.uniform(0.06, 0.2) : 0.0};
  Mesh mesh;
  scene.ways.route.half_width_m = half - 0.75 > 0.1 ? half - 0.75 : 0.1;
  // A staircase-like way: turns alternate left and right, so it never meets itself.
  Place at{};
  int turn = random.chance(0.5) ? 1 : -1;
  double total = 0;
  scene.ways.route.points.push_back(at.origin);
  while (total < length_m) {
    const double length = random.uniform(8, 30);
    const Surface wall = finish.left;
    if (random.chance(0.3)) finish.left = library.any(2.0, blank, random);
    const double slope = random.chance(0.25) ? random.uniform(-0.07, 0.07) : 0.0;
    // Sheared, not turned: walls stay upright, and meet the level corners without a gap.
    const Place ramp{at.origin, at.x + Vec3{0, 0, slope}, at.y, at.z};
    add_piece(mesh, ramp, length, half, height, finish, library, random);
    scene.objects.push_back(mesh.take());
    for (double x = random.uniform(1, 3); x < length; x += random.uniform(3, 6)) {
      Surface lamp = library.surface(Pattern::kBlank, 1.0, random);
      lamp.emission = 1.5f;
      mesh.quad(ramp.point(x - 0.5, 0.1, height - 0.02), ramp.point(x + 0.5, 0.1, height - 0.02),
                ramp.point(x + 0.5, -0.1, height - 0.02), ramp.point(x - 0.5, -0.1, height - 0.02), lamp);
      scene.lamps.push_back({ramp.point(x, 0, height - 0.25), random.uniform(0.15, 0.6), random.chance(0.7)});
    }
    if (!mesh.empty()) scene.objects.push_back(mesh.take());
    // The corner: a square with two open sides, straight ahead and away from the turn closed.
    const Place corner{ramp.point(length, 0, 0), at.x, at.y, at.z};
    const double w = 2 * half;
    const auto p = [&](double x, double y, double z) { return corner.point(x, y, z); };
    mesh.quad(p(0, -half, 0), p(w, -half, 0), p(w, half, 0), p(0, half, 0), finish.floor, {length, 0});
    mesh.quad(p(0, half, height), p(w, half, height), p(w, -half, height), p(0, -half, height),
              finish.ceiling);
    mesh.quad(p(w, half, 0), p(w, -half, 0), p(w, -half, height), p(w, half, height), wall);
    if (turn > 0)
      mesh.quad(p(w, -half, 0), p(0, -half, 0), p(0, -half, height), p(w, -half, height), finish.right);
    else
      mesh.quad(p(0, half, 0), p(w, half, 0), p(w, half, height), p(0, half, height), finish.right);
    scene.objects.push_back(mesh.take());
    scene.ways.route.points.push_back(corner.point(half, 0, 0));
    scene.ways.sights.push_back(corner.point(half, 0, 1.2));
    at = corner.at(half, turn * half, 0).turned(turn * kQuarter);
    turn = -turn;
    total += length + w;
  }
  scene.ways.route.points.push_back(at.point(0.4, 0, 0));
  // The dead end.
  mesh.quad(at.point(0.5, half, 0), at.point(0.5, -half, 0), at.point(0.5, -half, height),
            at.point(0.5, half, height), finish.door);
  scene.objects.push_back(mesh.take());
  scene.ways.route.speed_limit_m_s.assign(scene.ways.route.points.size(), random.uniform(1.4, 2.5));
  light_indoors(scene, 0.01, 0.3, random);
  return scene;
}

}  // namespace egofocus::citysim
