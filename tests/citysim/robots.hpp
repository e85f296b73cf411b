// Robots on ways made by hand, for tests: a town, a pavement, a corridor, a room, a desk.
#pragma once

#include <cstdint>

#include "citysim/drive.hpp"
#include "citysim/fly.hpp"
#include "citysim/motion_bus.hpp"

namespace egofocus::citysim::test {

inline Ways town_ways() {
  Ways ways;
  ways.route.points = {{0, 0, 0},    {150, 0, 2},   {150, 80, 4}, {60, 80, 5},
                       {60, 160, 3}, {-40, 160, 0}, {-40, 60, 1}};
  ways.route.speed_limit_m_s = {14, 8, 14, 14, 20, 8, 10};
  ways.route.half_width_m = 3;
  ways.route.closed = true;
  return ways;
}

inline Ways pavement_ways() {
  Ways ways;
  ways.route.points = {{0, 0, 0}, {18, 0, 0.5}, {18, 12, 1}, {30, 20, 1}, {30, 2, 0}};
  ways.route.speed_limit_m_s = {3, 3, 2, 3, 3};
  ways.route.half_width_m = 1;
  return ways;
}

inline Ways corridor_ways() {
  Ways ways;
  ways.route.points = {{0, 0, 0}, {10, 0, 0}, {10, 6, 0}, {16, 6, 0}};
  ways.route.speed_limit_m_s = {1.5, 1.5, 1.5, 1.5};
  ways.route.half_width_m = 0.8;
  return ways;
}

/// Two boxes that overlap in a door.
inline Ways room_ways() {
  Ways ways;
  ways.boxes = {{{0, 0, 0.5}, {4, 3, 2}}, {{3, 2, 0.6}, {7, 6, 2}}};
  ways.sights = {{2, 5, 1}, {-1, 1, 1}, {8, 3, 1.5}, {3, -1, 0.5}, {5, 7, 1}};
  return ways;
}

inline Ways desk_ways() {
  Ways ways;
  ways.boxes = {{{-0.5, -0.7, 0.2}, {0.1, 0.7, 0.6}}};
  ways.sights = {{0.6, 0, 0.1}, {0.7, 0.2, 0.2}};
  return ways;
}

enum class Robot { kCar, kDelivery, kCorridor, kHand, kDrone, kSlider, kArm };
inline constexpr Robot kRobots[] = {Robot::kCar,   Robot::kDelivery, Robot::kCorridor, Robot::kHand,
                                    Robot::kDrone, Robot::kSlider,   Robot::kArm};

inline const char* name_of(Robot robot) {
  constexpr const char* kNames[] = {"car", "delivery robot", "corridor robot", "hand", "drone", "slider",
                                    "arm"};
  return kNames[static_cast<int>(robot)];
}

inline Trajectory move(Robot robot, double duration_s, std::uint64_t seed) {
  switch (robot) {
    case Robot::kCar:
      return drive(town_ways(), drive_style(Vehicle::kCar, seed), duration_s, seed);
    case Robot::kDelivery:
      return drive(pavement_ways(), drive_style(Vehicle::kDeliveryRobot, seed), duration_s, seed);
    case Robot::kCorridor:
      return drive(corridor_ways(), drive_style(Vehicle::kCorridorRobot, seed), duration_s, seed);
    case Robot::kHand:
      return fly(room_ways(), fly_style(Flyer::kHand, seed), duration_s, seed);
    case Robot::kDrone:
      return fly(room_ways(), fly_style(Flyer::kDrone, seed), duration_s, seed);
    case Robot::kSlider:
    case Robot::kArm:
      break;
  }
  return slide(desk_ways(), slide_style(robot == Robot::kArm, seed), duration_s, seed);
}

inline BusRobot bus_of(Robot robot) {
  switch (robot) {
    case Robot::kCar:
      return BusRobot::kCar;
    case Robot::kDelivery:
    case Robot::kCorridor:
      return BusRobot::kDeliveryRobot;
    case Robot::kHand:
      return BusRobot::kHand;
    case Robot::kDrone:
      return BusRobot::kDrone;
    case Robot::kSlider:
    case Robot::kArm:
      break;
  }
  return BusRobot::kArm;
}

/// Looks along body x, 0.1 rad down, off the body's origin by a lever arm.
inline Mount camera_of(Robot robot) {
  Mount mount;
  const sim::Mat3 along_x{{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}};
  mount.rotation = sim::rotation({0, 0.1, 0}) * along_x;
  switch (robot) {
    case Robot::kCar:
      mount.position = {1.6, 0.2, 1.3};
      break;
    case Robot::kDelivery:
    case Robot::kCorridor:
      mount.position = {0.35, 0, 0.5};
      break;
    case Robot::kHand:
    case Robot::kDrone:
    case Robot::kSlider:
    case Robot::kArm:
      mount.position = {0.06, 0.01, -0.03};
      break;
  }
  return mount;
}

}  // namespace egofocus::citysim::test
