// What a bus and the sensors on it can do.
#include <linux/can/error.h>

#include "trial.hpp"

namespace egofocus::reliability {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;

Row down_and_up() {
  Robot robot;
  Trial trial("CAN interface down and up", "ENETDOWN, 2 s", robot);
  robot.kernel.interfaces["can0"].up = false;
  robot.kernel.fail(ENETDOWN);
  robot.run(2 * kSecond_us);
  robot.kernel.interfaces["can0"].up = true;
  trial.over();
  trial.expect(trial.up("can_link_downs") == 1, "not seen");
  return trial.row();
}

Row unplugged() {
  Robot robot;
  Trial trial("CAN adapter unplugged and back, 20 times",
              "the interface is gone for 0.5 s, and has another number", robot);
  for (int i = 0; i < 20; ++i) {
    robot.kernel.fail(ENETDOWN);
    robot.kernel.fail(ENODEV);
    robot.kernel.interfaces.clear();
    robot.run(kSecond_us / 2);
    robot.kernel.queue.clear();
    robot.kernel.interfaces["can0"] = {10 + i};
    robot.run(kSecond_us);
  }
  trial.over();
  trial.expect(trial.up("can_link_losses") == 20, "not 20 losses");
  return trial.row();
}

Row bus_off() {
  SocketCanConfig can;
  can.restart_after_us = 500'000;
  Robot robot(Robot::engine_config(), can);
  Trial trial("bus-off",
              "error frame, nothing is heard until the node is restarted, restart_after_us = 500000", robot);
  robot.kernel.error_frame(CAN_ERR_BUSOFF, {});
  robot.trouble.can_silent = true;
  for (int i = 0; robot.kernel.links_set.empty() && i < 1'000; ++i) robot.run(Robot::kStep_us);
  robot.trouble = {};
  trial.over();
  robot.run(kSecond_us);
  trial.expect(trial.up("can_bus_off") == 1 && trial.up("can_restarts") == 1, "not seen, or not restarted");
  return trial.row();
}

Row imu_silent() {
  Robot robot;
  Trial trial("IMU silent", "1 s without gyro and accelerometer, wheels go on", robot);
  robot.trouble.imu_silent = true;
  robot.run(kSecond_us);
  const Seen seen = trial.seen();
  robot.trouble = {};
  trial.over();
  trial.expect((seen.flags & kStaleVelocity) != 0, "frames do not say so");
  return trial.row();
}

Row motion_silent() {
  Robot robot;
  Trial trial("all motion silent", "2 s without a frame on the bus", robot);
  robot.trouble.can_silent = true;
  robot.run(2 * kSecond_us);
  const Seen seen = trial.seen();
  robot.trouble = {};
  trial.over();
  trial.expect((seen.flags & (kStaleVelocity | kNoMotion)) == (kStaleVelocity | kNoMotion),
               "frames do not say so");
  return trial.row();
}

Row odometry_silent() {
  Robot robot;
  Trial trial("wheels silent", "1 s without a wheel speed while the robot goes from 0.5 m/s to 1 m/s", robot);
  robot.trouble.wheel_silent = true;
  robot.trouble.accel_m_s2 = 0.5;
  robot.run(kSecond_us);
  robot.trouble = {};
  trial.over();
  return trial.row();
}

Row wheel_stuck() {
  Robot robot;
  Trial trial("wheel speed stuck",
              "goes on saying 0.5 m/s for 2 s, while the robot goes from 0.5 m/s to 1.5 m/s", robot);
  robot.trouble.wheel_stuck = true;
  robot.trouble.accel_m_s2 = 0.5;
  robot.run(2 * kSecond_us);
  robot.trouble = {};
  trial.over();
  return trial.row();
}

}  // namespace

std::vector<Fault> motion_faults() {
  return {{"can_down", down_and_up},   {"can_unplugged", unplugged},      {"can_bus_off", bus_off},
          {"imu_silent", imu_silent},  {"wheel_silent", odometry_silent}, {"motion_silent", motion_silent},
          {"wheel_stuck", wheel_stuck}};
}

}  // namespace egofocus::reliability
