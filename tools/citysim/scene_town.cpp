#include <algorithm>
#include <utility>

#include "citysim/scenes.hpp"
#include "citysim/things.hpp"
#include "citysim/town_plan.hpp"
#include "citysim/town_street.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kQuarter = 1.5707963267948966;
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
    furnish_street(street, style_, on_pavement_, scene_, random_);
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
    sky.ambient = random.log_uniform(0.001, 0.01);
    sky.zenith = 0.3 * sky.ambient;
    sky.horizon = sky.ambient;
    sky.clouds = 0.2;
    scene.flicker_depth = random.uniform(0.05, 0.35);
    scene.flicker_hz = random.chance(0.7) ? 100 : 120;
    // 1 is about 200 lux, so a low beam's 10,000 cd and more are 30 and more, but not all around.
    scene.headlight = way.on_pavement ? random.log_uniform(0.5, 4.0) : random.log_uniform(3.0, 30.0);
  } else {
    const bool overcast = random.chance(0.4);
    sky.sun = overcast ? 0.1 : random.uniform(0.5, 1.0);
    sky.ambient = overcast ? random.uniform(0.5, 0.8) : random.uniform(0.2, 0.4);
    sky.zenith = random.uniform(0.6, 1.0);
    sky.horizon = random.uniform(0.8, 1.2);
    sky.clouds = random.uniform(0.0, 0.35);
    sky.haze_m = random.chance(0.3) ? random.uniform(300, 1500) : 0.0;
  }
  const double right = way.on_pavement ? style.street_half_m + 0.5 * style.pavement_m : lane_m(style);
  scene.ways.route = plan.route(right, way.on_pavement ? 2.0 : random.uniform(8, 20));
  if (way.on_pavement) scene.ways.route.half_width_m = 0.6;
  finish_scene(scene);
  return scene;
}

}  // namespace egofocus::citysim
