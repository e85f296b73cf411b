#include "citysim/town_street.hpp"

#include <algorithm>
#include <utility>

#include "citysim/things.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kQuarter = 1.5707963267948966;

class Furnisher {
 public:
  Furnisher(const TownStyle& style, bool on_pavement, Scene& scene, Random& random)
      : style_(style), on_pavement_(on_pavement), scene_(scene), random_(random), library_(*scene.library) {}

  /// What stands on the pavement to the right of the way along (or against) the street, and at the kerb.
  void furnish(const Street& street, bool against) {
    const double side = against ? 1.0 : -1.0;
    // Where the robot goes along the pavement it must get through.
    const bool way = on_pavement_ && !(against ? street.free_against : street.free_along);
    const double kerb = style_.street_half_m + (way ? 0.15 : 0.35);
    const double wall = style_.street_half_m + style_.pavement_m;
    Mesh mesh;
    double lamp_at = street.from + style_.lamp_m * random_.uniform(0.2, 0.8);
    for (double s = street.from + 3; s < street.to - 3; s += random_.uniform(3.0, 6.0)) {
      if (random_.chance(0.35 * style_.trees))
        add_tree(mesh, street.place(s, side * (kerb + (way ? 0.0 : 0.3)), against), library_, random_);
      else if (random_.chance(0.12))
        add_sign(mesh, street.place(s, side * kerb, against), library_, random_);
      else if (random_.chance(0.3 * style_.clutter)) {
        add_clutter(mesh, street.place(s, side * (wall - (way ? 0.2 : 0.4)), against),
                    way ? random_.uniform(0.2, 0.45) : random_.uniform(0.3, 1.0), library_, random_);
      } else if (random_.chance(0.25 * style_.clutter)) {
        add_bush(mesh, street.place(s, side * (wall + (way ? 0.9 : 0.4)), against), library_, random_);
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
      if (style_.night) scene_.lamps.push_back({head, random_.log_uniform(1.5, 8.0), random_.chance(0.5)});
    }
    // A robot on the pavement crosses the side streets at their ends.
    const double clear = on_pavement_ ? style_.pavement_m + 1.0 : 0.0;
    const double end = street.to - clear;
    for (double s = street.from + clear; s < end; s += random_.uniform(8, 25)) {
      if (!random_.chance(style_.people)) continue;
      if (way) continue;
      add_person(mesh, Place{}, library_, random_);
      const double d =
          side * (style_.street_half_m + random_.uniform(0.6, std::max(0.7, style_.pavement_m - 0.3)));
      const double pace = random_.chance(0.25) ? 0.0 : random_.uniform(0.6, 1.8);
      move(mesh, street, s, std::min(s + 14.0, end), d, kKerb_m, pace, random_.chance(0.5));
    }
  }

  void traffic(const Street& street) {
    for (const bool against : {false, true}) {
      if (!(against ? street.free_against : street.free_along) || !random_.chance(style_.traffic)) continue;
      Mesh mesh;
      add_car(mesh, Place{}, library_, style_.night, random_);
      const double clear = on_pavement_ ? style_.pavement_m + 3.5 : 0.0;
      move(mesh, street, street.from + clear, street.to - clear, (against ? 1.0 : -1.0) * lane_m(style_), 0,
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
        add_house(mesh, base, length, random_.uniform(7, 12), style_.night, library_, random_);
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

 private:
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

  void place_object(Mesh& mesh) {
    if (!mesh.empty()) scene_.objects.push_back(mesh.take());
  }

  const TownStyle& style_;
  bool on_pavement_;
  Scene& scene_;
  Random& random_;
  const TextureLibrary& library_;
};

}  // namespace

Vec3 Street::point(double s, double d, double above) const {
  return along_x ? plan.ground(s, fixed + d, above) : plan.ground(fixed - d, s, above);
}

Place Street::place(double s, double d, bool against) const {
  const double angle = (along_x ? 0.0 : kQuarter) + (against ? 2 * kQuarter : 0.0);
  return along_x ? plan.place(s, fixed + d, angle) : plan.place(fixed - d, s, angle);
}

double lane_m(const TownStyle& style) {
  const double parked_m = style.parked > 0 ? 2.1 : 0.3;
  return std::max(0.9, 0.5 * (style.street_half_m - parked_m));
}

void furnish_street(const Street& street, const TownStyle& style, bool on_pavement, Scene& scene,
                    Random& random) {
  Furnisher furnisher(style, on_pavement, scene, random);
  for (const bool against : {false, true}) {
    furnisher.furnish(street, against);
    furnisher.houses(street, against);
  }
  furnisher.traffic(street);
}

}  // namespace egofocus::citysim
