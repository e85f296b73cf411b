// What the network is trained on is what the runtime makes: the binding's stack against the Engine, byte for
// byte.
#include "window_stack.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <vector>

#include "recording/error.hpp"
#include "recording/replay.hpp"
#include "recording_windows.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using training::ClassicalDepth;
using training::RecordingWindows;
using training::WindowStack;

namespace {

recording::Folder planes(MotionSource source) {
  recording::Folder folder =
      recording::open_folder(std::filesystem::path(egofocus::test::source_dir()) / "fixtures/planes", source);
  folder.camera.config.backend = Backend::kFocus;  // what the stack itself has
  return folder;
}

/// The Engine's frame and the stack's own depth are the same bytes.
void require_same(const DepthFrame& frame, bool has_stack, WindowStack& stack) {
  REQUIRE(has_stack == (frame.hypotheses > 0));
  if (!has_stack) return;
  REQUIRE(stack.ladder().count == frame.hypotheses);
  REQUIRE(stack.ladder().step_per_m / 256.0 == frame.inverse_depth_scale_per_m);
  REQUIRE(stack.ladder().begin_us == frame.window_begin_us);
  REQUIRE(stack.events() == frame.events);
  REQUIRE(stack.warp().votes() == frame.votes);
  const ClassicalDepth depth = stack.classical(true);
  REQUIRE(std::equal(depth.index_q8.begin(), depth.index_q8.end(), frame.inverse_depth.begin(),
                     frame.inverse_depth.end()));
  REQUIRE(std::equal(depth.confidence.begin(), depth.confidence.end(), frame.confidence.begin(),
                     frame.confidence.end()));
}

std::uint64_t sum_of_planes(const WindowStack& stack) {
  std::uint64_t sum = 0;
  for (int k = 0; k < stack.ladder().count; ++k)
    for (const std::uint8_t n : stack.warp().plane(k)) sum += n;
  return sum;
}

}  // namespace

TEST_CASE("a recording's windows give the Engine's frames") {
  for (const MotionSource source : {MotionSource::kOdometry, MotionSource::kPoses}) {
    recording::Replay replay(planes(source));
    replay.start(replay.default_first_tick_us());
    RecordingWindows windows(planes(source));
    DepthFrame frame;
    int with_depth = 0;
    while (replay.tick(frame)) {
      CAPTURE(frame.t_us, static_cast<int>(source));
      const bool has_stack = windows.tick(frame.t_us);
      require_same(frame, has_stack, windows.stack());
      if (!has_stack) continue;
      ++with_depth;
      CHECK(sum_of_planes(windows.stack()) == frame.votes);  // nothing saturates here
    }
    CHECK(with_depth >= 15);
  }
}

TEST_CASE("a window from 20 samples of motion, as training has it, gives the Engine's frame") {
  // Noise far below a double's last bit makes the Engine go through EgoMotion::samples().
  recording::Folder folder = planes(MotionSource::kOdometry);
  folder.camera.config.velocity_noise.percent = 1e-200;
  folder.camera.config.velocity_noise.kind = NoiseKind::kDeviation;
  recording::Replay replay(std::move(folder));
  replay.start(replay.default_first_tick_us());
  RecordingWindows windows(planes(MotionSource::kOdometry));
  DepthFrame frame;
  int compared = 0;
  while (replay.tick(frame)) {
    CAPTURE(frame.t_us);
    if (!windows.tick(frame.t_us)) continue;
    const std::vector<MotionSample> motion = windows.motion();
    const std::int64_t oldest_us = frame.t_us - replay.config().window.max_age_us;
    if (motion.front().t_us != oldest_us) continue;
    WindowStack stack(replay.config(), {});
    for (const Event& event : windows.events()) stack.add(event);
    const bool has_stack = stack.run(oldest_us, frame.t_us,
                                     [&motion](std::int64_t begin_us, std::int64_t end_us, MotionTrack& out) {
                                       integrate_track(motion, begin_us, end_us, out);
                                       return true;
                                     });
    require_same(frame, has_stack, stack);
    ++compared;
  }
  CHECK(compared >= 15);
}

TEST_CASE("the stack of a crop is the crop of the stack, and a kept ray table changes nothing") {
  RecordingWindows windows(planes(MotionSource::kOdometry));
  constexpr std::int64_t kTick_us = 700'000;
  REQUIRE(windows.tick(kTick_us));
  const WindowStack& whole = windows.stack();
  const std::vector<MotionSample> motion = windows.motion();
  const Config& config = whole.config();
  std::vector<Ray> rays(static_cast<std::size_t>(config.camera.intrinsics.width_px) *
                        static_cast<std::size_t>(config.camera.intrinsics.height_px));
  fill_rays(config.camera, rays);
  const auto track = [&motion](std::int64_t begin_us, std::int64_t end_us, MotionTrack& out) {
    integrate_track(motion, begin_us, end_us, out);
    return true;
  };
  const std::vector<Event> events = windows.events();
  const training::Crop crop{37, 22, 96, 80};
  WindowStack full(config, {});
  WindowStack part(config, crop, rays);
  for (const Event& event : events) full.add(event), part.add(event);
  REQUIRE(full.run(kTick_us - 200'000, kTick_us, track));
  REQUIRE(part.run(kTick_us - 200'000, kTick_us, track));
  REQUIRE(part.ladder().count == full.ladder().count);
  REQUIRE(part.ladder().step_per_m == full.ladder().step_per_m);
  std::size_t differ = 0;
  std::size_t hit = 0;
  for (int k = 0; k < full.ladder().count; ++k) {
    for (int y = 0; y < crop.height; ++y) {
      for (int x = 0; x < crop.width; ++x) {
        const std::uint8_t mine = part.warp().plane(k)[static_cast<std::size_t>(y * crop.width + x)];
        differ += mine != full.warp().plane(
                              k)[static_cast<std::size_t>((y + crop.y) * full.grid().width_px + x + crop.x)];
        hit += mine > 0;
      }
    }
  }
  CHECK(hit > 10'000);
  CHECK(differ == 0);
}

TEST_CASE("what cannot be stacked is refused with a message") {
  const Config config = planes(MotionSource::kOdometry).camera.config;
  CHECK_THROWS_WITH(WindowStack(config, {200, 0, 96, 80}), Catch::Contains("does not lie in the grid"));
  CHECK_THROWS_WITH(WindowStack(config, {0, 0, 8, 8}), Catch::Contains("below 16 px"));
  Config bad = config;
  bad.ladder.hypotheses = 36;
  CHECK_THROWS_AS(WindowStack(bad, {}), recording::Error);
  RecordingWindows windows(planes(MotionSource::kPoses));
  windows.tick(500'000);
  CHECK_THROWS_WITH(windows.tick(500'000), Catch::Contains("must rise"));
}
