#include "citysim/fly.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "citysim/free_space.hpp"
#include "citysim/random.hpp"
#include "citysim/shake.hpp"
#include "core/elementary.hpp"

namespace egofocus::citysim {
namespace {

using sim::dot;
using sim::Random;

constexpr double kGravity_m_s2 = 9.80665;
constexpr double kPlan_s = 0.5;   // between two points of the plan
constexpr int kFinePerPlan = 25;  // 0.02 s

enum class Mood { kTravel, kDrift, kTurn, kStand, kDeadStill };

/// One control point of the plan, a coarse spline.
struct PlanPoint {
  Vec3 position{0, 0, 0};
  double yaw = 0;
  double pitch = 0;
  double roll = 0;
  double tremor = 0;  // share of the style's, 0..1
};

/// Walks through the boxes, point by point. Each four neighbouring points lie in one box, so the spline does.
class Planner {
 public:
  Planner(const Ways& ways, const FlyStyle& style, std::vector<FreeBox> boxes, Random random)
      : style_(style), boxes_(std::move(boxes)), sights_(ways.sights), random_(random) {
    now_.position = random_point(boxes_[0], random_);
    goal_ = random_point(boxes_[0], random_);
    choose_sight();
    const Heading heading = heading_to(now_.position, sight_, 0);
    now_.yaw = heading.yaw;
    now_.pitch = clamped(-style_.max_pitch_rad, heading.pitch, style_.max_pitch_rad);
  }

  PlanPoint next() {
    if (left_-- <= 0) change_mood();
    move();
    turn();
    return now_;
  }

 private:
  void change_mood() {
    const double dice = random_.uniform();
    mood_ = dice < 0.60   ? Mood::kTravel
            : dice < 0.70 ? Mood::kDrift
            : dice < 0.85 ? Mood::kTurn
            : dice < 0.94 ? Mood::kStand
                          : Mood::kDeadStill;
    if (style_.flyer == Flyer::kDrone && mood_ == Mood::kDeadStill) mood_ = Mood::kStand;
    const bool travel = mood_ == Mood::kTravel;
    left_ = static_cast<int>((travel ? random_.uniform(4, 10) : random_.uniform(2.0, 4.5)) / kPlan_s);
    if (!travel && mood_ != Mood::kDrift) left_ += 3;  // a spline stands only after four equal points
    speed_ = travel ? random_.log_uniform(std::max(0.6, style_.min_speed_m_s), style_.max_speed_m_s)
                    : style_.min_speed_m_s * random_.uniform(0.7, 1.5);
    const bool leftwards = random_.chance(0.5);
    sweep_ = style_.max_rate_rad_s * random_.uniform(0.3, 0.85) * (leftwards ? 1 : -1);
    nod_ = 0.3 * style_.max_rate_rad_s * random_.uniform(-1, 1);
    tremor_ = mood_ == Mood::kDeadStill ? 0 : random_.uniform(0.4, 1.0);
    if (travel) choose_goal();
  }

  /// Of two sights mostly the nearer one: who looks only across the room sees nothing near.
  void choose_sight() {
    const auto any = [&] { return sights_[random_.below(static_cast<std::uint32_t>(sights_.size()))]; };
    const auto distance2 = [&](const Vec3& sight) {
      const Vec3 way = sight - now_.position;
      return dot(way, way);
    };
    sight_ = any();
    const Vec3 other = any();
    if (random_.chance(0.75) && distance2(other) < distance2(sight_)) sight_ = other;
  }

  /// Of three points the farthest: short ways give no speed.
  Vec3 far_point(const FreeBox& box) {
    Vec3 best = now_.position;
    double most = -1;
    for (int i = 0; i < 3; ++i) {
      const Vec3 point = random_point(box, random_);
      const Vec3 way = point - now_.position;
      if (dot(way, way) <= most) continue;
      most = dot(way, way);
      best = point;
    }
    return best;
  }

  /// Half of all goals beyond the box lie in another one that shares a part with it.
  void choose_goal() {
    goal_ = far_point(boxes_[box_]);
    if (crossing_ > 0 || boxes_.size() < 2 || random_.chance(0.5)) return;
    const std::size_t other = random_.below(static_cast<std::uint32_t>(boxes_.size()));
    FreeBox part;
    if (other == box_ || !shared_part(boxes_[box_], boxes_[other], part)) return;
    goal_ = random_point(part, random_);
    next_box_ = other;
    door_ = part;
    to_door_ = true;
  }

  void move() {
    Vec3 wish{0, 0, 0};
    const bool moving = mood_ == Mood::kTravel || mood_ == Mood::kDrift;
    if (moving) {
      Vec3 way = goal_ - now_.position;
      double distance = square_root(dot(way, way));
      if (distance < 0.3 && crossing_ == 0 && !to_door_) {
        goal_ = far_point(boxes_[box_]);
        way = goal_ - now_.position;
        distance = square_root(dot(way, way));
      }
      const double slower = std::min(speed_, distance / kPlan_s);
      wish = (slower / (distance + 1e-9)) * way;
    }
    Vec3 change = wish - velocity_;
    const double most = style_.max_acceleration_m_s2 * kPlan_s;
    const double size = square_root(dot(change, change));
    if (size > most) change = (most / size) * change;
    velocity_ = velocity_ + change;
    const Vec3 before = now_.position;
    now_.position = limited_to(crossing_ > 0 ? door_ : boxes_[box_], before + kPlan_s * velocity_);
    velocity_ = (1 / kPlan_s) * (now_.position - before);
    pass_door();
  }

  /// Four points and more in the shared part, then the other box is open.
  void pass_door() {
    if (crossing_ > 0) {
      if (--crossing_ > 0) return;
      box_ = next_box_;
      goal_ = random_point(boxes_[box_], random_);
    } else if (to_door_ && contains(door_, now_.position)) {
      to_door_ = false;
      crossing_ = 5;
      goal_ = random_point(door_, random_);
    }
  }

  void turn() {
    if (random_.chance(0.12)) choose_sight();
    if (random_.chance(0.2)) roll_goal_ = style_.max_roll_rad * random_.uniform(-1, 1);
    const Heading heading = heading_to(now_.position, sight_, now_.yaw);
    double yaw_step = heading.yaw - now_.yaw;
    double pitch_step = clamped(-style_.max_pitch_rad, heading.pitch, style_.max_pitch_rad) - now_.pitch;
    double roll_step = roll_goal_ - now_.roll;
    if (mood_ == Mood::kTurn) {
      yaw_step = sweep_ * kPlan_s;
      pitch_step = nod_ * kPlan_s;
      if (absolute(now_.pitch + pitch_step) > style_.max_pitch_rad) pitch_step = 0;
    }
    if (mood_ == Mood::kDeadStill) yaw_step = pitch_step = roll_step = 0;
    if (style_.flyer == Flyer::kDrone) {
      yaw_step *= 0.5;
      roll_step = 0;
    }
    const double size =
        square_root(yaw_step * yaw_step + pitch_step * pitch_step + roll_step * roll_step) + 1e-9;
    const double calm = mood_ == Mood::kDrift || mood_ == Mood::kStand ? 0.15 : 0.8;
    const double most = calm * style_.max_rate_rad_s * kPlan_s;
    const double share = mood_ == Mood::kTurn ? 1.0 : std::min(1.0, most / size);
    now_.yaw += share * yaw_step;
    now_.pitch += share * pitch_step;
    now_.roll += share * roll_step;
    now_.tremor = tremor_;
  }

  const FlyStyle& style_;
  std::vector<FreeBox> boxes_;
  const std::vector<Vec3>& sights_;
  Random random_;
  PlanPoint now_;
  Vec3 velocity_{0, 0, 0};
  Vec3 goal_;
  Vec3 sight_;
  Mood mood_ = Mood::kStand;
  int left_ = 0;
  double speed_ = 0;
  double sweep_ = 0;
  double nod_ = 0;
  double tremor_ = 0;
  double roll_goal_ = 0;
  std::size_t box_ = 0;
  std::size_t next_box_ = 0;
  FreeBox door_{};
  bool to_door_ = false;
  int crossing_ = 0;  // points still to be laid in the shared part
};

/// Six tremors, of position and angles.
class Tremor {
 public:
  explicit Tremor(Random random)
      : shakes_{shake(random), shake(random), shake(random), shake(random), shake(random), shake(random)} {}
  /// Bound of each coordinate's share of a tremor of 1 m/s.
  [[nodiscard]] double reach() const {
    return std::max({shakes_[0].bound(), shakes_[1].bound(), shakes_[2].bound()});
  }
  void add(double t_s, double metres, double radians, Trajectory::Control& c) const {
    for (std::size_t i = 0; i < 3; ++i) c.position[i] += metres * shakes_[i].at(t_s);
    c.yaw += radians * shakes_[3].at(t_s);
    c.pitch += radians * shakes_[4].at(t_s);
    c.roll += radians * shakes_[5].at(t_s);
  }

 private:
  static Shake shake(Random& random) { return {random, 3, 11}; }
  std::array<Shake, 6> shakes_;
};

/// How a drone leans into its acceleration; `level` is without tremor.
void lean(const RigidState& level, Trajectory::Control& c) {
  const double sy = sine(c.yaw);
  const double cy = cosine(c.yaw);
  const Vec3 push = level.pose.rotation * level.acceleration_m_s2;
  c.pitch += (cy * push[0] + sy * push[1]) / kGravity_m_s2;
  c.roll -= (cy * push[1] - sy * push[0]) / kGravity_m_s2;
}

}  // namespace

FlyStyle fly_style(Flyer flyer, std::uint64_t seed) {
  Random random(seed, "fly style");
  FlyStyle style;
  style.flyer = flyer;
  style.max_rate_rad_s = random.uniform(0.8, 1.5);
  const double nervous = random.log_uniform(0.4, 2);
  style.tremor_m_s *= nervous;
  style.tremor_rad_s *= nervous;
  if (flyer == Flyer::kHand) {
    style.max_speed_m_s = random.uniform(0.9, 1.5);
    style.max_acceleration_m_s2 = random.uniform(2.5, 4.5);
    return style;
  }
  style.min_speed_m_s = 0.2;
  style.max_speed_m_s = random.uniform(1.5, 4.0);
  style.max_acceleration_m_s2 = random.uniform(2, 4);
  style.max_roll_rad = 0;
  style.max_pitch_rad = 0.25;
  style.tremor_rad_s *= 0.6;
  return style;
}

Trajectory fly(const Ways& ways, const FlyStyle& style, double duration_s, std::uint64_t seed) {
  if (!(duration_s > 0 && duration_s <= 1000)) throw std::invalid_argument("a flight lasts up to 1000 s");
  const Tremor tremor{Random(seed, "tremor")};
  Planner planner(ways, style, inner_boxes(ways, style.margin_m + tremor.reach() * style.tremor_m_s),
                  Random(seed, "flight plan"));

  const auto plans = static_cast<std::size_t>(duration_s / kPlan_s) + 6;
  std::vector<PlanPoint> plan;
  for (std::size_t i = 0; i < plans; ++i) plan.push_back(planner.next());
  std::vector<Trajectory::Control> coarse;
  std::vector<Trajectory::Control> shaken;  // the tremor's share rides on a spline of its own
  for (const PlanPoint& p : plan) {
    coarse.push_back({p.position, p.yaw, p.pitch, p.roll});
    shaken.push_back({{p.tremor, 0, 0}, 0, 0, 0});
  }
  const Trajectory level(std::move(coarse), kPlan_s);
  const Trajectory share(std::move(shaken), kPlan_s);

  constexpr double kFine_s = kPlan_s / kFinePerPlan;
  const std::size_t fine = static_cast<std::size_t>(duration_s / kFine_s + 0.999999) + 3;
  std::vector<Trajectory::Control> controls;
  for (std::size_t i = 0; i < fine; ++i) {
    const double t = static_cast<double>(i) * kFine_s;
    Trajectory::Control c = level.control_at(t);
    if (style.flyer == Flyer::kDrone) lean(level.body_at(t), c);
    const double part = share.control_at(t).position[0];
    tremor.add(t, part * style.tremor_m_s, part * style.tremor_rad_s, c);
    controls.push_back(c);
  }
  return {std::move(controls), kFine_s};
}

}  // namespace egofocus::citysim
