#include "support/plane_simulator.hpp"

#include <utility>

namespace egofocus::sim {
namespace {

constexpr Vec3 kLeverArmM{0.10, 0.02, 0.05};

recording::CameraFile make_camera() {
  recording::CameraFile file;
  CameraModel& camera = file.config.camera;
  camera.intrinsics = {240, 180, 200.0, 199.0, 121.5, 88.5};
  camera.distortion = Distortion::kPlumbBob;
  const double coefficients[5] = {-0.15, 0.08, 0.0004, -0.0003, 0};
  for (int i = 0; i < 5; ++i) camera.coefficients[i] = coefficients[i];
  file.config.grid = camera.intrinsics;
  file.config.ladder.z_near_m = 0.95;
  file.config.ladder.span_px = 40;  // sideways, the wall moves 10 px in a window, the nearest rectangle 28
  file.config.motion.source = MotionSource::kOdometry;
  for (int i = 0; i < 3; ++i)
    file.config.motion.camera_in_body_m[i] = kLeverArmM[static_cast<std::size_t>(i)];
  file.config.rate.rate_hz = 1e6 / PlaneSimulator::kTickPeriodUs;
  file.depth_scale_m = PlaneSimulator::kDepthScaleM;
  return file;
}

/// Standing at the world's origin, level, looking along world x.
CameraPose start_pose() {
  return {{{{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}}}, kLeverArmM};
}

std::vector<Phase> make_phases() {
  return {{400000, {}},
          {400000, {{1.00, 0, 0}, {0, 0, 0}}},
          {350000, {{0, 0, 1.75}, {0, 0, 0}}},
          {350000, {{-1.00, 0.15, 0.20}, {0.05, -0.12, 0.20}}},
          {350000, {{0, 0, 0}, {-0.05, 0.35, -0.20}}},
          {300000, {}}};
}

}  // namespace

PlaneSimulator::PlaneSimulator(std::uint64_t seed) : PlaneSimulator(seed, make_phases()) {}

PlaneSimulator::PlaneSimulator(std::uint64_t seed, std::vector<Phase> phases)
    : seed_(seed),
      camera_(make_camera()),
      trajectory_(start_pose(), std::move(phases)),
      scene_(PlaneScene::standard(seed)) {}

std::vector<PhaseSpan> PlaneSimulator::phases() {
  static constexpr const char* kNames[] = {"standstill", "lateral",       "forward",
                                           "mixed",      "pure rotation", "standstill"};
  std::vector<PhaseSpan> spans;
  std::int64_t begin = 0;
  for (const Phase& phase : make_phases()) {
    const Vec3& velocity = phase.twist.velocity_m_s;
    spans.push_back({kNames[spans.size()], begin + Trajectory::kRampUs, begin + phase.duration_us,
                     dot(velocity, velocity) > 0});
    begin += phase.duration_us;
  }
  return spans;
}

std::vector<Event> PlaneSimulator::events(std::int64_t until_us) {
  const std::vector<Ray> rays = pixel_rays(camera_.config.camera);
  EventSensor sensor(camera_.config.camera.intrinsics, SensorFaults{}, seed_);
  std::vector<double> view(rays.size());
  std::vector<Event> events;
  const CameraPose* seen_from = nullptr;
  for (std::int64_t t = 0; t <= until_us && t <= trajectory_.duration_us(); t += kViewPeriodUs) {
    const CameraPose& pose = trajectory_.pose_at(t);
    const bool moved =
        !seen_from || pose.position != seen_from->position || pose.rotation != seen_from->rotation;
    if (moved) {
      scene_.look_from(pose);
      for (std::size_t i = 0; i < rays.size(); ++i) view[i] = scene_.cast(rays[i].x, rays[i].y).log_intensity;
      seen_from = &pose;
    }
    sensor.show(t, view, events);
  }
  return events;
}

recording::Grey16Picture PlaneSimulator::depth(std::int64_t t_us) {
  const Intrinsics& grid = camera_.config.grid;
  scene_.look_from(trajectory_.pose_at(t_us));
  recording::Grey16Picture picture(grid.width_px, grid.height_px);
  for (std::int32_t v = 0; v < grid.height_px; ++v) {
    for (std::int32_t u = 0; u < grid.width_px; ++u) {
      const Hit hit = scene_.cast((u - grid.cx_px) / grid.fx_px, (v - grid.cy_px) / grid.fy_px);
      const double units = floor_of(hit.depth_m / kDepthScaleM + 0.5);
      picture.at(u, v) = units > 65535 ? std::uint16_t{0} : static_cast<std::uint16_t>(units);
    }
  }
  return picture;
}

std::vector<PoseSample> PlaneSimulator::poses() const {
  std::vector<PoseSample> poses;
  for (std::int64_t t = 0; t <= trajectory_.duration_us(); t += kPosePeriodUs) {
    const CameraPose& at = trajectory_.pose_at(t);
    const std::array<double, 4> q = quaternion(at.rotation);
    PoseSample pose;
    pose.t_us = t;
    for (std::size_t i = 0; i < 3; ++i) pose.position_m[i] = at.position[i];
    for (std::size_t i = 0; i < 4; ++i) pose.orientation_xyzw[i] = q[i];
    poses.push_back(pose);
  }
  return poses;
}

std::string PlaneSimulator::can_log() const {
  return sim::can_log(trajectory_, camera_.config.motion, MotionFaults{}, seed_ + 100);
}

std::array<double, 4> quaternion(const Mat3& m) {
  // Four times the square of each component, from the diagonal; the largest one is divided by.
  const double squares[4] = {1 + m[0][0] - m[1][1] - m[2][2], 1 - m[0][0] + m[1][1] - m[2][2],
                             1 - m[0][0] - m[1][1] + m[2][2], 1 + m[0][0] + m[1][1] + m[2][2]};
  std::size_t largest = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (squares[i] > squares[largest]) largest = i;
  }
  const double sums[3] = {m[2][1] + m[1][2], m[0][2] + m[2][0], m[1][0] + m[0][1]};         // yz, zx, xy
  const double differences[3] = {m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]};  // xw, yw, zw
  std::array<double, 4> q{};
  const double divisor = 2.0 * square_root(squares[largest]);
  q[largest] = square_root(squares[largest]) / 2.0;
  for (std::size_t i = 0; i < 4; ++i) {
    if (i == largest) continue;
    if (largest == 3) {
      q[i] = differences[i] / divisor;
    } else if (i == 3) {
      q[i] = differences[largest] / divisor;
    } else {
      q[i] = sums[3 - i - largest] / divisor;
    }
  }
  if (q[3] < 0) {
    for (double& component : q) component = -component;
  }
  return q;
}

}  // namespace egofocus::sim
