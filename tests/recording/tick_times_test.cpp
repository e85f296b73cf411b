// The shipped recording at irregular times, as truth of other data sets has them, against the grid.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <vector>

#include "recording/evaluation.hpp"
#include "recording/replay.hpp"
#include "support/frame_hash.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::recording;

namespace {

std::filesystem::path planes() {
  return std::filesystem::path(egofocus::test::source_dir()) / "fixtures/planes";
}

struct Found {
  std::map<std::int64_t, std::uint64_t> frames;  // time -> hash of all but the number of the tick
  Health health;
};

Found replay_at(const std::vector<std::int64_t>& times, MotionSource source) {
  Folder folder = open_folder(planes(), source);
  folder.camera.config.backend = Backend::kFocus;
  Replay replay(std::move(folder));
  replay.start(times.front());
  Found found;
  for (const std::int64_t t_us : times) {
    replay.set_next_tick(t_us);
    DepthFrame frame;
    REQUIRE(replay.tick(frame));
    REQUIRE(frame.t_us == t_us);
    frame.sequence = 0;
    egofocus::test::FrameHash hash;
    hash.add(frame);
    found.frames[t_us] = hash.value();
  }
  found.health = replay.engine().health();
  return found;
}

}  // namespace

TEST_CASE("the shipped recording at irregular times: the maps of the grid, byte for byte") {
  const MotionSource source = GENERATE(MotionSource::kOdometry, MotionSource::kPoses);
  std::vector<std::int64_t> grid;
  for (std::int64_t t_us = 400'000; t_us <= 1'600'000; t_us += 50'000) grid.push_back(t_us);
  // 10 Hz with jitter of microseconds to milliseconds; every third is a grid point.
  const std::vector<std::int64_t> irregular = {600'000,   703'412,   799'997,   900'000,   1'000'013,
                                               1'102'950, 1'200'000, 1'200'001, 1'398'001, 1'500'000};
  const Found expected = replay_at(grid, source);
  const Found found = replay_at(irregular, source);
  for (const std::int64_t t_us : {600'000, 900'000, 1'200'000, 1'500'000}) {
    INFO(t_us << " us");
    CHECK(found.frames.at(t_us) == expected.frames.at(t_us));
  }
  CHECK(found.frames.at(1'200'000) != found.frames.at(1'200'001));
  CHECK(found.health.events.late + found.health.imu.late + found.health.odometry.late +
            found.health.poses.late ==
        0);
  CHECK(found.health.ticks.late + found.health.ticks.skipped == 0);
}

TEST_CASE("an evaluation at the truth's times gives the figures of the grid where both meet") {
  EvalOptions options;
  options.methods = {"focus"};
  options.range.cut_m = options.range.clip_max_m = 10;
  options.max_images = 14;
  const SequenceScore at_truth = evaluate(planes(), options);
  options.on_grid = true;
  options.max_images = 14;
  const SequenceScore on_grid = evaluate(planes(), options);
  REQUIRE(at_truth.images.size() == 14);
  REQUIRE(on_grid.images.size() == 14);
  CHECK(at_truth.after_events == 1);
  CHECK(at_truth.over_limit == 28);
  CHECK(at_truth.without_tick + at_truth.same_time == 0);
  for (std::size_t metric = 0; metric < kMetrics; ++metric) {
    INFO(kMetricNames[metric]);
    const double a = at_truth.methods[0].sets[kAllCommon].mean()[metric];
    const double b = on_grid.methods[0].sets[kAllCommon].mean()[metric];
    CHECK((a == b || (a != a && b != b)));
  }
  CHECK(at_truth.methods[0].sets[kAllCommon].count() == 5);
}
