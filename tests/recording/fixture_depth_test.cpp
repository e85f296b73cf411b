// The shipped recording through the whole pipeline, against the simulator's exact depth and motion.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "recording/depth_error.hpp"
#include "recording/replay.hpp"
#include "support/plane_simulator.hpp"
#include "support/source_dir.hpp"
#include "support/true_parallax.hpp"

using namespace egofocus;

namespace {

constexpr double kEnoughParallaxPx = 4.0;

/// Relative errors of many pixels; one without an estimate counts as wrong by 100 %.
struct Errors {
  std::vector<double> values;

  void add(const DepthFrame& frame, std::span<const float> truth_m, std::span<const double> parallax_px) {
    std::vector<float> depth_m(truth_m.size());
    metric_depth(frame, recording::kFarthestTruthM, depth_m);
    for (std::size_t i = 0; i < truth_m.size(); ++i) {
      if (!(parallax_px[i] >= kEnoughParallaxPx)) continue;
      const double truth = static_cast<double>(truth_m[i]);
      values.push_back(depth_m[i] > 0 ? std::abs(static_cast<double>(depth_m[i]) - truth) / truth : 1.0);
    }
  }
  [[nodiscard]] double median() {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }
  [[nodiscard]] double within(double limit) const {
    const auto count = std::count_if(values.begin(), values.end(), [=](double e) { return e <= limit; });
    return static_cast<double>(count) / static_cast<double>(values.size());
  }
};

std::vector<float> metres(const recording::Grey16Picture& picture) {
  std::vector<float> depth_m;
  for (const std::uint16_t units : picture.pixels) {
    depth_m.push_back(static_cast<float>(units * sim::PlaneSimulator::kDepthScaleM));
  }
  return depth_m;
}

/// Has the camera's centre stayed where it is for as long as a window may reach back?
bool stands_still(std::span<const PoseSample> poses, std::int64_t from_us, std::int64_t tick_us) {
  for (const PoseSample& pose : poses) {
    if (pose.t_us < from_us || pose.t_us > tick_us) continue;
    const sim::CentreShift c = sim::centre_shift(poses, pose.t_us, tick_us);
    if (std::hypot(c.x, c.y, c.z) > 1e-6) return false;
  }
  return true;
}

bool is_blank(const DepthFrame& frame) {
  return std::all_of(frame.confidence.begin(), frame.confidence.end(), [](std::uint8_t c) { return c == 0; });
}

/// Against the trajectory, in the camera's frame.
double velocity_error(const DepthFrame& frame, const sim::Vec3& truth) {
  const double* v = frame.velocity_m_s;
  return std::hypot(v[0] - truth[0], v[1] - truth[1], v[2] - truth[2]) / square_root(sim::dot(truth, truth));
}

void replay_fixture(MotionSource source, const char* name) {
  sim::PlaneSimulator simulator;
  const std::vector<PoseSample> poses = simulator.poses();
  recording::Folder folder =
      recording::open_folder(std::filesystem::path(egofocus::test::source_dir()) / "fixtures/planes", source);
  folder.camera.config.backend = Backend::kFocus;
  recording::Replay replay(std::move(folder));
  replay.start(sim::PlaneSimulator::kTickPeriodUs);

  struct PhaseResult {
    Errors errors;
    int ticks = 0;
    double worst_velocity = 0;
  };
  const std::vector<sim::PhaseSpan> phases = simulator.phases();
  std::vector<PhaseResult> results(phases.size());
  Errors all;
  Errors carried;
  int still_ticks = 0;
  int carried_ticks = 0;
  DepthFrame frame;
  while (replay.tick(frame)) {
    CAPTURE(name, frame.t_us);
    const std::int64_t oldest_us = frame.t_us - replay.config().window.max_age_us;
    if (stands_still(poses, oldest_us, frame.t_us)) {
      ++still_ticks;
      CHECK((frame.flags & kNoParallax) != 0);
      CHECK(frame.hypotheses == 0);
      if (all.values.empty()) {
        CHECK(is_blank(frame));
        continue;
      }
      ++carried_ticks;
      CHECK((frame.flags & kCarried) != 0);
      CHECK(frame.age_us > 0);
      const std::vector<float> truth_m = metres(simulator.depth(frame.t_us));
      carried.add(frame, truth_m, std::vector<double>(truth_m.size(), kEnoughParallaxPx));
      continue;
    }
    const std::int64_t begin_us = sim::window_begin_us(poses, replay.config(), frame.t_us);
    for (std::size_t i = 0; i < phases.size(); ++i) {
      if (!phases[i].has_parallax || begin_us < phases[i].begin_us || frame.t_us > phases[i].end_us) continue;
      CHECK(frame.flags == 0);
      // Poses are 5 ms apart, the window's choices 1.6 ms.
      CHECK(std::abs(frame.window_begin_us - begin_us) <= 10'000);
      const double nearest_rho = 256 * frame.inverse_depth_scale_per_m * (frame.hypotheses - 1);
      const LadderConfig& ladder = replay.config().ladder;
      CHECK(frame.hypotheses <= ladder.hypotheses);
      CHECK((frame.hypotheses == ladder.hypotheses || nearest_rho * ladder.z_near_m > 1));
      const std::vector<float> truth_m = metres(simulator.depth(frame.t_us));
      const std::vector<double> parallax_px =
          sim::parallax_px(sim::centre_shift(poses, begin_us, frame.t_us), frame.grid, truth_m);
      results[i].errors.add(frame, truth_m, parallax_px);
      all.add(frame, truth_m, parallax_px);
      ++results[i].ticks;
      const double error = velocity_error(frame, simulator.trajectory().twist_at(frame.t_us).velocity_m_s);
      results[i].worst_velocity = std::max(results[i].worst_velocity, error);
    }
  }

  // The first standstill has 8 ticks; 7 windows lie within the turn on the spot and the last standstill.
  CHECK(still_ticks == 15);
  REQUIRE(carried_ticks == 7);
  std::printf("planes, %-8s carried  %d ticks: median %.2f %%, within 10 %% %.1f %%\n", name, carried_ticks,
              100 * carried.median(), 100 * carried.within(0.1));
  CHECK(carried.median() <= 0.05);
  CHECK(carried.within(0.1) >= 0.6);
  for (std::size_t i = 0; i < phases.size(); ++i) {
    if (!phases[i].has_parallax) continue;
    CAPTURE(name, phases[i].name);
    REQUIRE(results[i].ticks >= 2);
    Errors& errors = results[i].errors;
    std::printf(
        "planes, %-8s %-8s %d ticks, %6zu px: median %.2f %%, within 10 %% %.1f %%; velocity %.2f %%\n", name,
        phases[i].name, results[i].ticks, errors.values.size(), 100 * errors.median(),
        100 * errors.within(0.1), 100 * results[i].worst_velocity);
    CHECK(errors.median() <= 0.03);
    CHECK(errors.within(0.1) >= 0.75);  // the rest lies along the edges of the rectangles
    CHECK(results[i].worst_velocity <= 0.03);
  }
  std::printf("planes, %-8s all      median %.2f %%, within 10 %% %.1f %%; %d ticks without parallax\n", name,
              100 * all.median(), 100 * all.within(0.1), still_ticks);
  CHECK(all.median() <= 0.03);
}

}  // namespace

TEST_CASE("the fixture's depth from IMU and body velocity is right, or flagged") {
  replay_fixture(MotionSource::kOdometry, "odometry");
}

TEST_CASE("the fixture's depth from poses is right, or flagged") {
  replay_fixture(MotionSource::kPoses, "poses");
}
