#include "citysim/recording_texts.hpp"

#include <cstdio>

#include "citysim/can_bus.hpp"
#include "egofocus/version.hpp"
#include "recording/camera_toml.hpp"
#include "recording/json.hpp"
#include "recording/pose_file.hpp"

namespace egofocus::citysim {
namespace {

constexpr std::int64_t kTrajectoryStepUs = 5000;

double seconds(std::int64_t t_us) {
  return 1e-6 * static_cast<double>(t_us);
}

/// x y z w of a rotation matrix; the largest component is found first, so that no root is near 0.
void to_quaternion(const Mat3& r, double (&q)[4]) {
  const double trace = r[0][0] + r[1][1] + r[2][2];
  if (trace > 0) {
    const double s = 2.0 * square_root(trace + 1.0);
    q[3] = 0.25 * s;
    q[0] = (r[2][1] - r[1][2]) / s;
    q[1] = (r[0][2] - r[2][0]) / s;
    q[2] = (r[1][0] - r[0][1]) / s;
    return;
  }
  const std::size_t i = r[0][0] > r[1][1] ? (r[0][0] > r[2][2] ? 0 : 2) : (r[1][1] > r[2][2] ? 1 : 2);
  const std::size_t j = (i + 1) % 3;
  const std::size_t k = (i + 2) % 3;
  const double s = 2.0 * square_root(1.0 + r[i][i] - r[j][j] - r[k][k]);
  q[i] = 0.25 * s;
  q[j] = (r[j][i] + r[i][j]) / s;
  q[k] = (r[k][i] + r[i][k]) / s;
  q[3] = (r[k][j] - r[j][k]) / s;
}

PoseSample pose_sample(const Pose& pose, std::int64_t t_us) {
  PoseSample out;
  out.t_us = t_us;
  for (std::size_t i = 0; i < 3; ++i) out.position_m[i] = pose.position[i];
  to_quaternion(pose.rotation, out.orientation_xyzw);
  return out;
}

recording::CameraFile camera_file(const World& world, const MotionBus& bus) {
  recording::CameraFile file;
  Config& config = file.config;
  config.camera = world.camera;
  config.grid = world.grid;
  config.ladder.z_near_m = world.z_near_m;
  // A car always moves the same way, and errs the same way from tick to tick: nothing to fuse.
  const bool on_a_road = world.family <= Family::kTown5Night;
  config.carry.fuse_us = on_a_road ? 0 : 300'000;
  config.motion = bus.motion;
  config.motion.source = MotionSource::kOdometry;
  // 80,000 events on 346x260; the window grows with the picture.
  const double pixels = static_cast<double>(world.grid.width_px) * world.grid.height_px;
  config.window.max_events = static_cast<std::int32_t>(80000.0 * pixels / (346.0 * 260.0));
  file.depth_scale_m = world.depth_scale_m;
  file.can.dbc = "robot.dbc";
  file.can.motion = bus.can;
  return file;
}

}  // namespace

std::map<std::string, std::string> recording_texts(const World& world, const RecordingOptions& options,
                                                   double duration_s) {
  const MotionBus bus = motion_bus(world.trajectory, world.robot, draw_bus_faults(world.robot, options.seed),
                                   world.mount, options.seed);
  std::vector<PoseSample> poses;
  std::string velocities = "# t vx vy vz wx wy wz: seconds, m/s and rad/s of the camera in its own frame\n";
  for (std::int64_t t_us = 0; seconds(t_us) <= duration_s; t_us += kTrajectoryStepUs) {
    const RigidState state = world.camera_at(seconds(t_us));
    poses.push_back(pose_sample(state.pose, t_us));
    char line[160];
    std::snprintf(line, sizeof line, "%.6f %.9f %.9f %.9f %.9f %.9f %.9f\n", seconds(t_us),
                  state.velocity_m_s[0], state.velocity_m_s[1], state.velocity_m_s[2], state.rate_rad_s[0],
                  state.rate_rad_s[1], state.rate_rad_s[2]);
    velocities += line;
  }
  return {{"camera.toml", recording::camera_toml_text(camera_file(world, bus))},
          {"can.log", candump_text(bus.frames)},
          {"robot.dbc", bus.dbc},
          {"poses.txt", recording::poses_text(poses)},
          {"velocities.txt", velocities}};
}

std::string recording_facts(const World& world, const RecordingOptions& options,
                            const RecordingReport& report, const DvsCounters& sensor) {
  using recording::Json;
  Json drawn;
  for (const NamedValue& value : describe(world.sensor)) drawn.add(std::string(value.name), value.value);
  const BusFaults faults = draw_bus_faults(world.robot, options.seed);
  Json bus;
  bus.add("robot", static_cast<int>(world.robot))
      .add("gyro_scale", faults.gyro_scale)
      .add("gyro_noise_rad_s", faults.gyro_noise_rad_s)
      .add("accel_noise_m_s2", faults.accel_noise_m_s2)
      .add("odometry_scale", faults.odometry_scale)
      .add("odometry_noise_m_s", faults.odometry_noise_m_s)
      .add("imu_latency_us", faults.imu_latency_us)
      .add("odometry_latency_us", faults.odometry_latency_us)
      .add("dropout_every_s", faults.dropout_every_s);
  for (std::size_t i = 0; i < 3; ++i) {
    bus.add(std::string("gyro_bias_rad_s_") + "xyz"[i], faults.gyro_bias_rad_s[i]);
  }
  Json events;
  events.add("written", report.events)
      .add("signal", sensor.signal_events)
      .add("noise", sensor.noise_events)
      .add("refractory_dropped", sensor.refractory_dropped)
      .add("readout_dropped", sensor.readout_dropped);
  Json facts;
  facts.add("made_by", "citysim " EGOFOCUS_VERSION)
      .add("family", name_of(options.family))
      .add("seed", options.seed)
      .add("frames", options.frames)
      .add("width_px", options.width_px)
      .add("height_px", options.height_px)
      .add("clean_sensor", options.clean_sensor)
      .add("seconds", report.seconds)
      .add("lens_blur", world.blur)
      .add("flicker_hz", world.scene.flicker_depth > 0 ? world.scene.flicker_hz : 0.0)
      .add("flicker_depth", world.scene.flicker_depth)
      .add("views", report.views)
      .add("wide_steps_share", report.wide_steps_share)
      .add("events", events)
      .add("sensor", drawn)
      .add("bus", bus);
  return facts.json() + "\n";
}

}  // namespace egofocus::citysim
