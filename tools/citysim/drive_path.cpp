#include "citysim/drive_path.hpp"

#include <algorithm>
#include <stdexcept>

#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kCell = 0.05;            // of progress
constexpr double kMostRounded_rad = 2.4;  // sharper corners would need too much room
constexpr double kMostSlope = 0.25;
constexpr double kSteering_s = 1.0;
constexpr double kUsedWidth = 0.85;  // of the free half width, in corners

using sim::Vec3;

/// Smooth from 0 to 1; its derivative is the shape of a corner's curvature.
double smooth_step(double u) {
  return u * u * (3.0 - 2.0 * u);
}

double between(double low, double value, double high) {
  return value < low ? low : value > high ? high : value;
}

double flat_distance(const Vec3& a, const Vec3& b) {
  const double x = b[0] - a[0];
  const double y = b[1] - a[1];
  return square_root(x * x + y * y);
}

/// A corner of length 1 whose yaw rises by `turn` like smooth_step: how far before the corner it begins, and
/// how far its middle stays away from the corner.
struct UnitCorner {
  double tangent = 0;
  double cut = 0;
};

UnitCorner unit_corner(double turn) {
  constexpr int kSteps = 200;
  double x = 0;
  double y = 0;
  for (int i = 0; i < kSteps / 2; ++i) {
    const double yaw = turn * smooth_step((i + 0.5) / kSteps);
    x += cosine(yaw) / kSteps;
    y += sine(yaw) / kSteps;
  }
  // The second half mirrors the first: its middle lies on the corner's bisector.
  const double half = 0.5 * turn;
  const double chord = 2.0 * (x * cosine(half) + y * sine(half));
  const double tangent = chord / (2.0 * cosine(half));
  return {tangent, square_root((x - tangent) * (x - tangent) + y * y)};
}

}  // namespace

/// A point to drive to, and the limit of the piece that begins there.
struct DrivePath::Aim {
  Vec3 point;
  double speed_limit = 0;
};

/// What happens at an inner aim.
struct DrivePath::Corner {
  double turn = 0;     // rad
  double length = 0;   // of the rounded part; 0: in place, or straight on
  double tangent = 0;  // how far before and after the aim it begins and ends
  bool in_place = false;
};

std::vector<DrivePath::Aim> DrivePath::aims_of(const Route& route, const PathStyle& style, double length_m,
                                               sim::Random& random) {
  const std::size_t n = route.points.size();
  if (n < 2) throw std::invalid_argument("a route needs 2 points or more");
  if (route.speed_limit_m_s.size() != n)
    throw std::invalid_argument("a route needs a speed limit for each point");
  for (std::size_t i = 0; i < n; ++i) {
    if (!(route.speed_limit_m_s[i] > 0))
      throw std::invalid_argument("a route's speed limit must be positive");
    const bool leads_on = route.closed || i + 1 < n;
    if (leads_on && !(flat_distance(route.points[i], route.points[(i + 1) % n]) > 0.01))
      throw std::invalid_argument("two neighbouring points of a route are the same");
  }

  std::vector<Aim> aims{{route.points[0], route.speed_limit_m_s[0]}};
  std::size_t at = 0;
  bool back = false;
  for (double length = 0; length < length_m;) {
    if (!route.closed && at == (back ? 0 : n - 1)) {
      if (!style.turns_in_place) break;
      back = !back;
    }
    const std::size_t next = back ? at - 1 : (at + 1) % n;
    const double limit = route.speed_limit_m_s[back ? next : at];
    const Vec3& a = route.points[at];
    const Vec3& b = route.points[next];
    const double way = flat_distance(a, b);
    aims.back().speed_limit = limit;
    const double spacing = style.wander_spacing_m * random.uniform(0.7, 1.3);
    // Corners are cut into what is straight, so the aim does not wander near them.
    const double clear = std::max(spacing, 3 * style.corner_radius_m);
    for (double s = clear; s + clear < way; s += spacing * random.uniform(0.8, 1.4)) {
      const double aside = style.wander_half_width * route.half_width_m * random.uniform(-1, 1) / way;
      const Vec3 left{-(b[1] - a[1]) * aside, (b[0] - a[0]) * aside, 0};
      aims.push_back({a + (s / way) * (b - a) + left, limit});
    }
    aims.push_back({b, limit});
    length += way;
    at = next;
  }
  return aims;
}

DrivePath::DrivePath(const Route& route, const PathStyle& style, double length_m, sim::Random& random) {
  const std::vector<Aim> aims = aims_of(route, style, length_m, random);
  std::vector<Corner> corners(aims.size());
  for (std::size_t i = 1; i + 1 < aims.size(); ++i) {
    const Vec3 in = aims[i].point - aims[i - 1].point;
    const Vec3 out = aims[i + 1].point - aims[i].point;
    Corner& corner = corners[i];
    corner.turn = arc_tangent2(in[0] * out[1] - in[1] * out[0], in[0] * out[0] + in[1] * out[1]);
    const double sharpness = absolute(corner.turn);
    const bool whim = random.chance(style.in_place_chance) && sharpness > 0.6;
    if (style.turns_in_place && (whim || sharpness > kMostRounded_rad)) {
      corner.in_place = true;
      continue;
    }
    if (sharpness > kMostRounded_rad)
      throw std::invalid_argument("a route's corner is too sharp for a robot that cannot turn in place");
    const UnitCorner unit = unit_corner(sharpness);
    // The tightest point of a corner of length L has curvature 1.5 turn / L; nobody steers in less than a
    // second.
    const double tight = 1.5 * sharpness * style.corner_radius_m * random.uniform(0.85, 1.3);
    const double wanted = std::max(tight, aims[i].speed_limit * kSteering_s);
    const double room = 0.4 * std::min(flat_distance(aims[i - 1].point, aims[i].point),
                                       flat_distance(aims[i].point, aims[i + 1].point));
    // The corner's middle lies on the bisector, so it is nearer to both legs than to the corner itself.
    const double most_cut = kUsedWidth * route.half_width_m / cosine(0.5 * sharpness);
    corner.length = std::min({wanted, room / unit.tangent, most_cut / (unit.cut + 1e-9)});
    corner.tangent = corner.length * unit.tangent;
  }
  lay_pieces(aims, corners);
  lay_nodes(aims[0].point);
}

void DrivePath::lay_pieces(const std::vector<Aim>& aims, const std::vector<Corner>& corners) {
  const Vec3 first = aims[1].point - aims[0].point;
  double begin = 0;
  double yaw = arc_tangent2(first[1], first[0]);
  double z = aims[0].point[2];
  double slope = 0;
  const auto lay = [&](Kind kind, double length, double turn, double next_slope, double limit) {
    pieces_.push_back({kind, begin, length, yaw, turn, z, slope, next_slope - slope, limit});
    begin += length;
    yaw += turn;
    if (kind != Kind::kInPlace) z += length * 0.5 * (slope + next_slope);
    slope = next_slope;
  };
  for (std::size_t i = 0; i + 1 < aims.size(); ++i) {
    const double way = flat_distance(aims[i].point, aims[i + 1].point);
    const double straight = way - corners[i].tangent - corners[i + 1].tangent;
    const double limit = aims[i].speed_limit;
    // The straight part ends at the route's height, whatever the corner before it, whose slope blends into
    // this one, has lost or won.
    const double goal =
        aims[i + 1].point[2] - (aims[i + 1].point[2] - aims[i].point[2]) * corners[i + 1].tangent / way;
    const double before = 0.5 * corners[i].length;
    const double here = between(-kMostSlope, (goal - z - before * slope) / (straight + before), kMostSlope);
    if (i == 0) slope = here;
    const double slowest = i == 0 ? limit : std::min(limit, aims[i - 1].speed_limit);
    if (corners[i].in_place) lay(Kind::kInPlace, absolute(corners[i].turn), corners[i].turn, here, 100.0);
    if (corners[i].length > 0) lay(Kind::kTurn, corners[i].length, corners[i].turn, here, slowest);
    lay(Kind::kLine, straight, 0, here, limit);
  }
}

void DrivePath::lay_nodes(const Vec3& start) {
  Node node;
  node.x = start[0];
  node.y = start[1];
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const Piece& piece = pieces_[p];
    const int cells = static_cast<int>(piece.length / kCell) + 2;
    for (int i = 0; i < cells; ++i) {
      const double u = static_cast<double>(i) / cells;
      node.progress = piece.begin + u * piece.length;
      node.turn_per_progress = piece.turn / piece.length * 6.0 * u * (1.0 - u);
      node.speed_limit = piece.speed_limit;
      node.in_place = piece.kind == Kind::kInPlace;
      node.may_stop = piece.kind == Kind::kLine;
      node.piece = p;
      nodes_.push_back(node);
      const Vec3 next = step_from(node, piece.begin + (i + 1.0) / cells * piece.length);
      node.x = next[0];
      node.y = next[1];
    }
  }
  node.progress = pieces_.back().begin + pieces_.back().length;
  node.turn_per_progress = 0;
  nodes_.push_back(node);
}

double DrivePath::yaw_at(const Piece& piece, double progress) const {
  return piece.yaw + piece.turn * smooth_step(between(0, (progress - piece.begin) / piece.length, 1));
}

/// Along the yaw of the way's middle: the error is of third order in a cell.
Vec3 DrivePath::step_from(const Node& node, double progress) const {
  if (node.in_place) return {node.x, node.y, 0};
  const double way = progress - node.progress;
  const double yaw = yaw_at(pieces_[node.piece], node.progress + 0.5 * way);
  return {node.x + way * cosine(yaw), node.y + way * sine(yaw), 0};
}

DrivePath::Place DrivePath::at(double progress) const {
  const double s = between(0, progress, length());
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), s,
                                      [](double value, const Node& node) { return value < node.progress; });
  const Node& node = *(after - 1);
  const Piece& piece = pieces_[node.piece];
  const double u = between(0, (s - piece.begin) / piece.length, 1);
  Place place;
  place.position = step_from(node, s);
  place.yaw = yaw_at(piece, s);
  place.slope = piece.slope + piece.slope_change * smooth_step(u);
  place.in_place = node.in_place;
  // The slope's integral, smooth_step's being u^3 - u^4 / 2.
  const double risen =
      piece.length * (piece.slope * u + piece.slope_change * (u * u * u - 0.5 * u * u * u * u));
  place.position[2] = piece.z + (node.in_place ? 0 : risen);
  return place;
}

}  // namespace egofocus::citysim
