#include <algorithm>
#include <utility>

#include "citysim/indoors.hpp"
#include "citysim/scenes.hpp"
#include "citysim/things.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kQuarter = 1.5707963267948966;

class RoomBuilder {
 public:
  RoomBuilder(Scene& scene, Random& random)
      : scene_(scene),
        random_(random),
        library_(*scene.library),
        half_x_(0.5 * random.log_uniform(2.4, 8.0)),
        half_y_(0.5 * random.log_uniform(2.4, 6.5)),
        height_(random.uniform(2.3, 4.0)),
        low_(random.chance(0.25) ? height_ * random.uniform(0.6, 0.85) : height_),
        blank_(random.uniform(0.1, 0.8)) {}

  void build() {
    shell();
    for (double x = -half_x_ + 0.7; x < half_x_ - 0.6; x += random_.uniform(0.8, 1.6)) {
      if (random_.chance(0.75)) furniture({x, -half_y_, 0}, 0, height_);
      if (random_.chance(0.75)) furniture({x, half_y_, 0}, 2 * kQuarter, low_);
    }
    for (double y = -half_y_ + 1.3; y < half_y_ - 1.2; y += random_.uniform(0.8, 1.6)) {
      if (random_.chance(0.7)) furniture({-half_x_, y, 0}, -kQuarter, low_);
      if (random_.chance(0.7)) furniture({half_x_, y, 0}, kQuarter, low_);
    }
    middle();
    lamps();
  }

 private:
  /// The ceiling falls from height_ at -y to low_ at +y: an attic where they differ.
  [[nodiscard]] double ceiling(double y) const {
    return height_ + (low_ - height_) * (y + half_y_) / (2 * half_y_);
  }

  void take() {
    if (!mesh_.empty()) scene_.objects.push_back(mesh_.take());
  }

  void shell() {
    const Vec3 corners[4] = {
        {-half_x_, -half_y_, 0}, {half_x_, -half_y_, 0}, {half_x_, half_y_, 0}, {-half_x_, half_y_, 0}};
    const Surface floor = random_.chance(0.4) ? library_.surface(Pattern::kPlanks, 1.5, random_)
                                              : library_.any(2.0, 0.3, random_);
    mesh_.quad(corners[0], corners[1], corners[2], corners[3], floor);
    const auto above = [&](const Vec3& c) { return c + Vec3{0, 0, ceiling(c[1])}; };
    mesh_.quad(above(corners[3]), above(corners[2]), above(corners[1]), above(corners[0]),
               library_.any(2.0, low_ < height_ ? 0.5 : 0.8, random_));
    for (std::size_t i = 0; i < 4; ++i) {
      // Seen from inside with the corners counter-clockwise, the left end of a wall is the later corner.
      const Vec3& a = corners[(i + 1) % 4];
      const Vec3& b = corners[i];
      add_wall(mesh_, a, b, ceiling(a[1]), ceiling(b[1]),
               library_.any(random_.log_uniform(1.5, 4.0), blank_, random_));
      if (std::min(ceiling(a[1]), ceiling(b[1])) > 2.2) panels(a, b);
      scene_.ways.sights.push_back(0.5 * (a + b) + Vec3{0, 0, 1.2});
    }
    if (random_.chance(0.4)) {  // a rug
      const double w = random_.uniform(0.4, 0.8) * half_x_;
      const double l = random_.uniform(0.4, 0.8) * half_y_;
      const double up = 0.012;
      mesh_.quad({-w, -l, up}, {w, -l, up}, {w, l, up}, {-w, l, up}, library_.any(1.2, 0.1, random_));
    }
    take();
  }

  /// What hangs on the wall from a to b, from left to right.
  void panels(const Vec3& a, const Vec3& b) {
    const Vec3 along = b - a;
    const double length = square_root(dot(along, along));
    const Vec3 x = (1.0 / length) * along;
    const Place wall{a, x, cross(x, {0, 0, 1}), {0, 0, 1}};
    for (double at = random_.uniform(0.3, 1.2); at < length - 0.6;) {
      const double width = random_.log_uniform(0.2, 1.8);
      if (at + width > length - 0.2) break;
      if (random_.chance(0.6)) {
        const Surface surface = panel_surface(library_, random_);
        const double tall = random_.log_uniform(0.2, 1.2);
        add_panel(mesh_, wall.at(at + 0.5 * width, 0, random_.uniform(0.6, 1.4)), width, tall, surface);
      }
      at += width + random_.uniform(0.1, 1.2);
    }
  }

  /// Something at the wall, looking into the room; `under` is the ceiling there.
  void furniture(const Vec3& at, double angle, double under) {
    const Place place = Place{at, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}.turned(angle);
    switch (random_.below(9)) {
      case 0:
      case 1: {
        const double tall = random_.uniform(0.8, under - 0.2);
        add_shelf(mesh_, place, random_.uniform(0.6, 1.2), tall, library_, random_);
        break;
      }
      case 2:
      case 3: {
        const double high = random_.uniform(0.5, 0.95);
        add_table(mesh_, place.at(0, 0.35, 0), random_.uniform(0.8, 1.3), 0.65, high, library_, random_);
        for (int i = 0; i < 4; ++i) {
          const double size = random_.log_uniform(0.06, 0.35);
          const double deep = random_.uniform(0.15, 0.5);
          add_clutter(mesh_, place.at(random_.uniform(-0.4, 0.4), deep, high), size, library_, random_);
        }
        if (random_.chance(0.3))
          add_screen(mesh_, place.at(0, 0.2, high), random_.uniform(0.35, 0.7), library_, random_);
        break;
      }
      case 4:
        add_chair(mesh_, place.at(0, 0.35, 0), library_, random_);
        break;
      case 5:
        add_clutter(mesh_, place.at(0, 0.4, 0), random_.uniform(0.4, 0.8), library_, random_);
        break;
      case 6: {
        const double tall = random_.uniform(0.8, under - 0.2);
        const double deep = random_.uniform(0.35, 0.6);
        add_cupboard(mesh_, place, random_.uniform(0.5, 1.3), deep, tall, library_, random_);
        break;
      }
      case 7:
        add_sofa(mesh_, place, random_.uniform(0.9, 1.8), library_, random_);
        break;
      default:
        add_plant(mesh_, place.at(0, 0.4, 0), random_.uniform(0.5, 1.6), library_, random_);
        break;
    }
    scene_.ways.sights.push_back(at + Vec3{0, 0, random_.uniform(0.4, 1.3)});
    take();
  }

  /// What is kept free for the camera: the middle, or a ring around what stands there.
  void middle() {
    const double margin = 0.9;
    const double x = half_x_ - margin;
    const double y = half_y_ - margin;
    const double low = 0.25;
    const double high = std::max(low + 0.4, ceiling(y) - 0.3);
    if (x > 1.9 && y > 1.35 && random_.chance(0.8)) {
      const double in = 0.6;
      island(in, 0.4);
      scene_.ways.sights.push_back({0, 0, 0.9});
      const double free = in + 0.3;
      scene_.ways.boxes = {{{-x, -y, low}, {-free, y, high}},
                           {{-x, free, low}, {x, y, high}},
                           {{free, -y, low}, {x, y, high}},
                           {{-x, -y, low}, {x, -free, high}}};
    } else if (x < 0.3 || y < 0.3) {  // a closet: stand in the middle
      scene_.ways.boxes = {{{-0.3, -0.3, 1.0}, {0.3, 0.3, 1.5}}};
    } else {
      scene_.ways.boxes = {{{-x, -y, low}, {x, y, high}}};
    }
  }

  /// Within +-half_x, +-half_y: a table, a piece of wall, pillars, or somebody who stands there.
  void island(double half_x, double half_y) {
    switch (random_.below(4)) {
      case 0: {
        const Surface wall = library_.any(2.0, blank_, random_);
        mesh_.box(Place{}.turned(random_.uniform(-0.2, 0.2)), 2 * half_x - 0.1, 0.15, low_, wall, wall);
        break;
      }
      case 1: {
        const Surface pillar = library_.any(1.5, 0.5, random_);
        for (const double side : {-0.5, 0.5}) {
          const double radius = random_.uniform(0.08, 0.3);
          const int sides = 4 + static_cast<int>(random_.below(8));
          mesh_.prism(Place{}.at(side * half_x, 0, 0), sides, radius, low_, pillar);
        }
        break;
      }
      case 2:
        for (const double side : {-0.5, 0.5})
          add_person(mesh_, Place{}.at(side * half_x, 0, 0).turned(random_.uniform(-3, 3)), library_,
                     random_);
        break;
      default: {
        const double high = random_.uniform(0.6, 0.9);
        add_table(mesh_, Place{}, 2 * half_x, 2 * half_y, high, library_, random_);
        for (int i = 0; i < 6; ++i) {
          const double size = random_.log_uniform(0.08, 0.5);
          const double aside = random_.uniform(-0.3, 0.3);
          add_clutter(mesh_, Place{}.at(random_.uniform(-0.45, 0.45), aside, high), size, library_, random_);
        }
      }
    }
    take();
  }

  void lamps() {
    for (int i = 0; i < 2; ++i) {
      const double x = random_.uniform(-0.6, 0.6) * half_x_;
      const double y = random_.uniform(-0.6, 0.6) * half_y_;
      const Place hung{{x, y, ceiling(y) - 0.2}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
      Surface shade = library_.surface(Pattern::kBlank, 1.0, random_);
      shade.emission = 1.2f;
      const double side = random_.uniform(0.15, 0.5);
      mesh_.box(hung, side, random_.uniform(0.15, 0.5), 0.2, shade, shade, true);
      take();
      scene_.lamps.push_back({hung.point(0, 0, -0.1), random_.log_uniform(0.1, 1.5), random_.chance(0.5)});
    }
  }

  Scene& scene_;
  Random& random_;
  const TextureLibrary& library_;
  double half_x_, half_y_;
  double height_;
  double low_;    // of the ceiling, at +y
  double blank_;  // share of the walls
  Mesh mesh_;
};

}  // namespace

Scene make_room(std::shared_ptr<const TextureLibrary> library, std::uint64_t seed) {
  Random random(seed, "room");
  Scene scene;
  scene.library = std::move(library);
  RoomBuilder(scene, random).build();
  light_indoors(scene, 0.05, 0.6, random);
  return scene;
}

}  // namespace egofocus::citysim
