// The line that a wheeled robot's rear axle follows: a route with its corners rounded, or turned in place.
#pragma once

#include <vector>

#include "citysim/random.hpp"
#include "citysim/ways.hpp"

namespace egofocus::citysim {

struct PathStyle {
  double corner_radius_m = 7;      ///< wanted at a corner's tightest point; less where there is no room
  bool turns_in_place = false;     ///< at the ends of an open route, and at some corners
  double in_place_chance = 0;      ///< of corners above 0.6 rad
  double wander_spacing_m = 18;    ///< the driver's aim moves sideways this often
  double wander_half_width = 0.2;  ///< by at most this share of the free half width
};

/// Where the rear axle is after a given progress. Progress is the way driven in metres, and in a turn on the
/// spot the angle turned in radians. Curvature is continuous, so the yaw rate is, too.
class DrivePath {
 public:
  struct Place {
    sim::Vec3 position;
    double yaw = 0;    ///< of the path's tangent, not wrapped
    double slope = 0;  ///< rise per metre
    bool in_place = false;
  };
  /// Progress is cut into cells; this is where one begins.
  struct Node {
    double progress = 0;
    double x = 0;
    double y = 0;
    double turn_per_progress = 0;  ///< curvature, 1/m
    double speed_limit = 0;
    bool in_place = false;  ///< the cell that begins here is turned on the spot
    bool may_stop = false;  ///< on a straight piece
    std::size_t piece = 0;
  };

  /// Long enough for `length_m`, unless the route is open and the robot cannot turn around: then it ends
  /// there. Throws std::invalid_argument for a route without length, with as many limits as points missing,
  /// a limit that is not positive, or a corner that this robot cannot take.
  DrivePath(const Route& route, const PathStyle& style, double length_m, sim::Random& random);

  [[nodiscard]] const std::vector<Node>& nodes() const { return nodes_; }
  [[nodiscard]] double length() const { return nodes_.back().progress; }
  /// Limited to [0, length()].
  [[nodiscard]] Place at(double progress) const;

 private:
  enum class Kind { kLine, kTurn, kInPlace };
  struct Piece {
    Kind kind = Kind::kLine;
    double begin = 0;
    double length = 0;
    double yaw = 0;   // at its begin
    double turn = 0;  // to its end
    double z = 0;
    double slope = 0;
    double slope_change = 0;
    double speed_limit = 0;
  };
  struct Aim;
  struct Corner;

  static std::vector<Aim> aims_of(const Route& route, const PathStyle& style, double length_m,
                                  sim::Random& random);
  void lay_pieces(const std::vector<Aim>& aims, const std::vector<Corner>& corners);
  void lay_nodes(const sim::Vec3& start);
  [[nodiscard]] double yaw_at(const Piece& piece, double progress) const;
  [[nodiscard]] sim::Vec3 step_from(const Node& node, double progress) const;

  std::vector<Piece> pieces_;
  std::vector<Node> nodes_;
};

}  // namespace egofocus::citysim
