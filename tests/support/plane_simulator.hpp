// A whole recording of textured planes, made from nothing but arithmetic: the same bytes on every machine.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "recording/camera_toml.hpp"
#include "recording/picture.hpp"
#include "support/event_sensor.hpp"
#include "support/motion_bus.hpp"
#include "support/plane_scene.hpp"
#include "support/trajectory.hpp"

namespace egofocus::sim {

/// Where each kind of motion lies in the standard recording, in full motion (ramps left out).
struct PhaseSpan {
  const char* name;
  std::int64_t begin_us;
  std::int64_t end_us;
  bool has_parallax;
};

class PlaneSimulator {
 public:
  static constexpr std::int64_t kViewPeriodUs = 2500;  ///< image motion between two views stays below 1 px
  static constexpr std::int64_t kPosePeriodUs = 5000;
  static constexpr std::int64_t kTickPeriodUs = 50000;
  static constexpr double kDepthScaleM = 0.001;

  explicit PlaneSimulator(std::uint64_t seed = 1);
  /// Other ways through the same scene. Turns of more than about 1.5 rad/s leave more than 1 px between
  /// views.
  PlaneSimulator(std::uint64_t seed, std::vector<Phase> phases);

  /// Of the standard recording: standstill, lateral, forward, mixed, pure rotation, standstill: 2.15 s.
  [[nodiscard]] static std::vector<PhaseSpan> phases();

  [[nodiscard]] const recording::CameraFile& camera() const { return camera_; }
  [[nodiscard]] const Trajectory& trajectory() const { return trajectory_; }

  /// Sorted by time, of [0, until_us). Each call begins anew.
  [[nodiscard]] std::vector<Event> events(std::int64_t until_us);
  [[nodiscard]] std::vector<Event> events() { return events(trajectory_.duration_us()); }

  /// Exact depth along the optical axis on the undistorted working grid, in units of kDepthScaleM.
  [[nodiscard]] recording::Grey16Picture depth(std::int64_t t_us);

  [[nodiscard]] std::vector<PoseSample> poses() const;
  [[nodiscard]] std::string can_log() const;

 private:
  std::uint64_t seed_;
  recording::CameraFile camera_;
  Trajectory trajectory_;
  PlaneScene scene_;
};

/// Quaternion x, y, z, w of a rotation matrix; w >= 0.
std::array<double, 4> quaternion(const Mat3& m);

}  // namespace egofocus::sim
