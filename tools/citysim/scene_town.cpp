#include <algorithm>
#include <utility>

#include "citysim/scenes.hpp"
#include "citysim/things.hpp"
#include "citysim/town_plan.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kQuarter = 1.5707963267948966;
constexpr double kKerb_m = 0.12;

/// A stretch of street from crossing to crossing: s runs along it, d to its left, 0 at its middle.
struct Street {
  const TownPlan& plan;
  bool along_x;
  double fixed;  ///< the middle's other coordinate
  double from, to;
  bool free_along = true;    ///< the robot's way does not go along it
  bool free_against = true;  ///< nor back

  [[nodiscard]] Vec3 point(double s, double d, double above = 0) const {
    return along_x ? plan.ground(s, fixed + d, above) : plan.ground(fixed - d, s, above);
  }
  /// x along the street (or against it), y to the left of that.
  [[nodiscard]] Place place(double s, double d, bool against) const {
    const double angle = (along_x ? 0.0 : kQuarter) + (against ? 2 * kQuarter : 0.0);
    return along_x ? plan.place(s, fixed + d, angle) : plan.place(fixed - d, s, angle);
  }
};

/// From the street's middle to that of the right-hand lane; cars are parked at the kerb.
double lane_m(const TownStyle& style) {
  const double parked_m = style.parked > 0 ? 2.1 : 0.3;
  return std::max(0.9, 0.5 * (style.street_half_m - parked_m));
}

class Builder {
 public:
  Builder(const TownStyle& style, const TownPlan& plan, bool on_pavement, Scene& scene, Random& random)
      : style_(style),
        plan_(plan),
        on_pavement_(on_pavement),
        scene_(scene),
        random_(random),
        library_(*scene.library) {
    road_ = library_.surface(Pattern::kAsphalt, 4.0, random);
    slabs_ = library_.surface(random.chance(0.6) ? Pattern::kTiles : Pattern::kAsphalt, 2.5, random);
    kerb_ = library_.surface(Pattern::kNoise, 1.0, random);
    yard_ = library_.surface(random.chance(0.5) ? Pattern::kFoliage : Pattern::kNoise, 4.0, random);
    mark_ = library_.surface(Pattern::kBlank, 2.0, random);
    mark_.colour = {1.25f, 1.25f, 1.2f};
  }

  void build() {
    const double h = style_.street_half_m;
    for (const auto& [column, row] : plan_.built()) {
      const double x = plan_.column_x(column);
      const double y = plan_.row_y(row);
      crossing(x, y);
      const TownPlan::Crossing here{column, row};
      const TownPlan::Crossing east{column + 1, row};
      const TownPlan::Crossing north{column, row + 1};
      if (plan_.has(east)) {
        street({plan_, true, y, x + h, plan_.column_x(column + 1) - h, !plan_.travelled(here, east),
                !plan_.travelled(east, here)});
      }
      if (plan_.has(north)) {
        street({plan_, false, x, y + h, plan_.row_y(row + 1) - h, !plan_.travelled(here, north),
                !plan_.travelled(north, here)});
      }
      if (plan_.has({column + 1, row}) && plan_.has({column, row + 1}) && plan_.has({column + 1, row + 1})) {
        block(x, plan_.column_x(column + 1), y, plan_.row_y(row + 1));
      }
    }
  }

 private:
  /// A piece of ground between four points; texture coordinates are the plan's.
  void patch(Mesh& mesh, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, double u0, double u1,
             double v0, double v1, const Surface& surface) {
    mesh.triangle(a, b, c, {u0, v0}, {u1, v0}, {u1, v1}, surface);
    mesh.triangle(a, c, d, {u0, v0}, {u1, v1}, {u0, v1}, surface);
  }

  void place_object(Mesh& mesh) {
    if (!mesh.empty()) scene_.objects.push_back(mesh.take());
  }

  void crossing(double x, double y) {
    Mesh mesh;
    const double h = style_.street_half_m;
    constexpr int kParts = 3;
    // A little larger and lower than its hole: the streets' edges lie on it, no ray slips between.
    const double out = h + 0.15;
    const double step = 2 * out / kParts;
    for (int i = 0; i < kParts; ++i) {
      for (int j = 0; j < kParts; ++j) {
        const double x0 = x - out + i * step, x1 = x0 + step, y0 = y - out + j * step, y1 = y0 + step;
        patch(mesh, plan_.ground(x0, y0), plan_.ground(x1, y0), plan_.ground(x1, y1), plan_.ground(x0, y1),
              x0, x1, y0, y1, road_);
      }
    }
    place_object(mesh);
  }

  void street(const Street& street) {
    const double h = style_.street_half_m;
    const double length = street.to - street.from;
    const int steps = std::max(1, static_cast<int>(length / 4.0));
    const double edges[] = {-h, -h + 0.25, -h + 0.37, -0.07, 0.07, h - 0.37, h - 0.25, h};
    const bool marked = random_.chance(0.8);
    Mesh mesh;
    for (int i = 0; i < steps; ++i) {
      const double s0 = street.from + length * i / steps;
      const double s1 = street.from + length * (i + 1) / steps;
      for (std::size_t strip = 0; strip < 7; ++strip) {
        const bool line = strip == 1 || strip == 5 || (strip == 3 && i % 2 == 0);
        const double d0 = edges[strip];
        const double d1 = edges[strip + 1];
        patch(mesh, street.point(s0, d0), street.point(s1, d0), street.point(s1, d1), street.point(s0, d1),
              s0, s1, d0, d1, line && marked ? mark_ : road_);
      }
      for (const double side : {-1.0, 1.0}) pavement(mesh, street, s0, s1, side);
      if (i % 3 == 2 || i + 1 == steps) place_object(mesh);
    }
    for (const bool against : {false, true}) {
      furnish(street, against);
      houses(street, against);
    }
    traffic(street);
  }

  void pavement(Mesh& mesh, const Street& street, double s0, double s1, double side) {
    const double near = side * style_.street_half_m;
    const double far = side * (style_.street_half_m + style_.pavement_m);
    const Vec3 a = street.point(s0, near), b = street.point(s1, near);
    const Vec3 au = street.point(s0, near, kKerb_m), bu = street.point(s1, near, kKerb_m);
    const Vec3 cu = street.point(s1, far, kKerb_m), du = street.point(s0, far, kKerb_m);
    if (side > 0) {
      patch(mesh, a, b, bu, au, s0, s1, 0, kKerb_m, kerb_);
      patch(mesh, au, bu, cu, du, s0, s1, near, far, slabs_);
    } else {
      patch(mesh, b, a, au, bu, s1, s0, 0, kKerb_m, kerb_);
      patch(mesh, du, cu, bu, au, s0, s1, far, near, slabs_);
    }
  }

  void block(double x0, double x1, double y0, double y1) {
    const double inset = style_.street_half_m + style_.pavement_m;
    // To the middle of the kerb corner, so that no hole is left where two pavements meet.
    const double corner = style_.street_half_m;
    Mesh mesh;
    const int across = std::max(1, static_cast<int>((x1 - x0) / 12.0));
    const int down = std::max(1, static_cast<int>((y1 - y0) / 12.0));
    const double low = kKerb_m - 0.02;
    for (int i = 0; i < across; ++i) {
      for (int j = 0; j < down; ++j) {
        const auto at = [](double from, double to, int k, int n) { return from + (to - from) * k / n; };
        const double ax = at(x0 + corner, x1 - corner, i, across),
                     bx = at(x0 + corner, x1 - corner, i + 1, across);
        const double ay = at(y0 + corner, y1 - corner, j, down),
                     by = at(y0 + corner, y1 - corner, j + 1, down);
        patch(mesh, plan_.ground(ax, ay, low), plan_.ground(bx, ay, low), plan_.ground(bx, by, low),
              plan_.ground(ax, by, low), ax, bx, ay, by, yard_);
      }
      place_object(mesh);
    }
    const int trees = static_cast<int>(6.0 * style_.trees);
    for (int i = 0; i < trees; ++i) {
      const double x = random_.uniform(x0 + inset + 10, std::max(x0 + inset + 11, x1 - inset - 10));
      const double y = random_.uniform(y0 + inset + 10, std::max(y0 + inset + 11, y1 - inset - 10));
      add_tree(mesh, plan_.place(x, y, 0), library_, random_);
      place_object(mesh);
    }
  }

  /// What stands on the pavement to the right of the way along (or against) the street, and at the kerb.
  void furnish(const Street& street, bool against) {
    const double side = against ? 1.0 : -1.0;
    const double kerb = style_.street_half_m + 0.35;
    const double wall = style_.street_half_m + style_.pavement_m;
    Mesh mesh;
    double lamp_at = street.from + style_.lamp_m * random_.uniform(0.2, 0.8);
    for (double s = street.from + 3; s < street.to - 3; s += random_.uniform(3.0, 6.0)) {
      if (random_.chance(0.35 * style_.trees))
        add_tree(mesh, street.place(s, side * (kerb + 0.3), against), library_, random_);
      else if (random_.chance(0.12))
        add_sign(mesh, street.place(s, side * kerb, against), library_, random_);
      else if (random_.chance(0.3 * style_.clutter)) {
        add_clutter(mesh, street.place(s, side * (wall - 0.4), against), random_.uniform(0.4, 1.0), library_,
                    random_);
      } else if (random_.chance(0.25 * style_.clutter)) {
        add_bush(mesh, street.place(s, side * (wall + 0.4), against), library_, random_);
      }
      place_object(mesh);
    }
    for (double s = street.from + 7; s < street.to - 6; s += random_.uniform(5.6, 8.0)) {
      if (!random_.chance(style_.parked)) continue;
      add_car(mesh, street.place(s, side * (style_.street_half_m - 1.05), against), library_, false, random_);
      place_object(mesh);
    }
    for (; lamp_at < street.to; lamp_at += style_.lamp_m * random_.uniform(0.8, 1.2)) {
      Place base = street.place(lamp_at, side * kerb, against);
      base = base.turned(kQuarter);  // the arm reaches over the road, to the left
      const double height = random_.uniform(4.2, 6.5);
      const Vec3 head = add_lamp_post(mesh, base, height, 1.2, style_.night, library_, random_);
      place_object(mesh);
      if (style_.night) scene_.lamps.push_back({head, random_.uniform(0.6, 2.2), random_.chance(0.5)});
    }
    for (double s = street.from; s < street.to; s += random_.uniform(8, 25)) {
      if (!random_.chance(style_.people)) continue;
      if (on_pavement_ && !(against ? street.free_against : street.free_along)) continue;
      add_person(mesh, Place{}, library_, random_);
      const double d =
          side * (style_.street_half_m + random_.uniform(0.6, std::max(0.7, style_.pavement_m - 0.3)));
      const double pace = random_.chance(0.25) ? 0.0 : random_.uniform(0.6, 1.8);
      move(mesh, street, s, std::min(s + 14.0, street.to), d, kKerb_m, pace, random_.chance(0.5));
    }
  }

  /// Makes the mesh a mover from s0 to s1 (or back).
  void move(Mesh& mesh, const Street& street, double s0, double s1, double d, double above, double speed_m_s,
            bool back) {
    Object object = mesh.take();
    const Vec3 from = street.point(back ? s1 : s0, d, above);
    const Vec3 to = street.point(back ? s0 : s1, d, above);
    const Place facing = street.place(0.5 * (s0 + s1), d, back);
    object.moves = true;
    // Columns of the rotation are the axes of the place.
    object.start.rotation = sim::transpose(Mat3{facing.x, facing.y, facing.z});
    object.start.position = from;
    const Vec3 way = to - from;
    const double length = square_root(dot(way, way));
    if (speed_m_s > 0 && length > 0.5) {
      object.velocity_m_s = (speed_m_s / length) * way;
      object.period_s = length / speed_m_s;
      object.phase_s = random_.uniform(0, object.period_s);
    }
    scene_.objects.push_back(std::move(object));
  }

  void traffic(const Street& street) {
    for (const bool against : {false, true}) {
      if (!(against ? street.free_against : street.free_along) || !random_.chance(style_.traffic)) continue;
      Mesh mesh;
      add_car(mesh, Place{}, library_, style_.night, random_);
      move(mesh, street, street.from, street.to, (against ? 1.0 : -1.0) * lane_m(style_), 0,
           random_.uniform(3, 14), against);
    }
  }

  void houses(const Street& street, bool against) {
    const double side = against ? 1.0 : -1.0;
    const double front = style_.street_half_m + style_.pavement_m;
    for (double s = street.from + style_.pavement_m; s < street.to - style_.pavement_m - 6;) {
      const double length = std::min(random_.uniform(7, 20), street.to - style_.pavement_m - s);
      const double back = random_.chance(0.6) ? 0.0 : random_.uniform(0.5, 5.0);
      if (length > 5 && random_.chance(style_.houses)) {
        Mesh mesh;
        // The front looks to the street, so x runs with the street on its right side, against it on its left.
        Place base = street.place(s + 0.5 * length, side * (front + back), against);
        base.origin = base.origin - Vec3{0, 0, 0.7};
        add_house(mesh, base, length, random_.uniform(7, 12), library_, random_);
        place_object(mesh);
        if (back > 1.5 && random_.chance(0.5)) {  // a fence or hedge at the pavement
          Place fence = street.place(s + 0.5 * length, side * front, against);
          const Surface hedge = random_.chance(0.5) ? library_.surface(Pattern::kFoliage, 2.0, random_)
                                                    : library_.any(1.0, 0.3, random_);
          mesh.box(fence.at(0, -0.3, -0.2), length, 0.3, random_.uniform(0.7, 1.8), hedge, hedge);
          place_object(mesh);
        }
      }
      s += length + (random_.chance(0.5) ? 0.0 : random_.uniform(1, 8));
    }
  }

  const TownStyle& style_;
  const TownPlan& plan_;
  bool on_pavement_;
  Scene& scene_;
  Random& random_;
  const TextureLibrary& library_;
  Surface road_, slabs_, kerb_, yard_, mark_;
};

}  // namespace

Scene make_town(const TownStyle& style, const TownWay& way, std::shared_ptr<const TextureLibrary> library,
                std::uint64_t seed) {
  Random random(seed, "town");
  Scene scene;
  scene.library = std::move(library);
  const TownPlan plan(style, way.length_m, random);
  Builder(style, plan, way.on_pavement, scene, random).build();

  Sky& sky = scene.sky;
  sky.texture = scene.library->pick(Pattern::kClouds, random);
  const double angle = random.uniform(0, 4 * kQuarter);
  const double height = random.uniform(0.25, 1.2);
  sky.to_sun = {cosine(height) * cosine(angle), cosine(height) * sine(angle), sine(height)};
  if (style.night) {
    sky.sun = 0;
    sky.ambient = random.log_uniform(0.001, 0.006);
    sky.zenith = 0.3 * sky.ambient;
    sky.horizon = sky.ambient;
    sky.clouds = 0.2;
    scene.flicker_depth = random.uniform(0.05, 0.35);
    scene.flicker_hz = random.chance(0.7) ? 100 : 120;
    scene.headlight = random.uniform(0.5, 3.0);
  } else {
    const bool overcast = random.chance(0.4);
    sky.sun = overcast ? 0.1 : random.uniform(0.5, 1.0);
    sky.ambient = overcast ? random.uniform(0.5, 0.8) : random.uniform(0.2, 0.4);
    sky.zenith = random.uniform(0.6, 1.0);
    sky.horizon = random.uniform(0.8, 1.2);
    sky.clouds = random.uniform(0.0, 0.35);
    sky.haze_m = random.chance(0.3) ? random.uniform(300, 1500) : 0.0;
  }
  const double right = way.on_pavement ? style.street_half_m + 0.45 * style.pavement_m : lane_m(style);
  scene.ways.route = plan.route(right, way.on_pavement ? 2.0 : random.uniform(8, 20));
  finish_scene(scene);
  return scene;
}

}  // namespace egofocus::citysim
