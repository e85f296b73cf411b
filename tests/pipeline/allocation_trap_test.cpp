// Ticks under the trap. Source threads belong to the caller and may do as they like, so this program feeds
// spans instead.
#include <catch2/catch.hpp>
#include <vector>

#include "core/clock.hpp"
#include "core/worker_pool.hpp"
#include "support/allocation_trap.hpp"
#include "support/engine_in_block.hpp"
#include "support/network_vectors.hpp"
#include "support/sliding_scene.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

struct Fed {
  std::vector<Event> events;
  std::vector<PoseSample> poses;
  std::vector<OdometrySample> odometry;
  std::vector<ImuSample> imu;
};

}  // namespace

TEST_CASE("the trap can fail: it sees an allocation, a release, a lock and an exception, on any thread") {
  if (!trapping()) return;
  pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
  arm();
  int* volatile one = new int(1);
  delete one;
  void* volatile two = std::malloc(3);
  std::free(two);
  pthread_mutex_lock(&mutex);
  pthread_mutex_unlock(&mutex);
  bool caught = false;
  try {
    throw 1;
  } catch (int) {
    caught = true;
  }
  disarm();
  CHECK(caught);
  CHECK(allocations >= 2);
  CHECK(releases >= 2);
  CHECK(locks >= 1);
  CHECK(exceptions == 1);

  // A job that allocates, on a worker thread.
  WorkerPool pool;
  REQUIRE(pool.start(2, 0, -1).ok());
  const auto job = [](void*, int part, int) noexcept {
    if (part != 1) return;
    void* volatile block = std::malloc(5);  // volatile: or the compiler takes the pair away
    std::free(block);
  };
  pool.run(job, nullptr);
  arm();
  pool.run(job, nullptr);
  disarm();
  CHECK(allocations == 1);
  CHECK(releases == 1);
}

TEST_CASE("1,000 ticks with real work allocate, lock and throw nothing") {
  if (!trapping()) return;
  const int threads = GENERATE(1, 2);
  const Backend backend = GENERATE(Backend::kFocus, Backend::kNetwork);
  const test::ModelMemory model(test::file_bytes(test::source_dir() + "/fixtures/network/model.efm"));
  const ClockKind kind = GENERATE(ClockKind::kVirtual, ClockKind::kMonotonic);
  Config config = SlidingScene::config();
  config.threads = threads;
  config.backend = backend;
  config.model = model.bytes();
  config.ladder.hypotheses = 8;
  config.filter.refractory_us = 200;
  config.filter.isolated_us = 100'000;
  config.filter.hot_pixel_rate_hz = 1000;
  config.focus.cost = threads == 1 ? FocusCost::kGradient : FocusCost::kSti;
  config.motion.source = threads == 1 ? MotionSource::kPoses : MotionSource::kOdometry;
  config.rate.rate_hz = kind == ClockKind::kVirtual ? 50 : 500;
  EngineInBlock engine(config);
  REQUIRE(engine.status.ok());

  // Everything that will be fed lies ready before the first mark.
  const Clock clock = monotonic_clock();
  SlidingScene scene;
  constexpr int kTicks = 1000;
  constexpr std::int64_t kStep_us = 20'000;
  std::vector<Fed> fed;
  for (int i = 0; i < kTicks; ++i) {
    const std::int64_t from = i * kStep_us;
    fed.push_back({scene.events(from, from + kStep_us), SlidingScene::poses(from, from + kStep_us),
                   SlidingScene::odometry(from, from + kStep_us), SlidingScene::imu(from, from + kStep_us)});
  }
  const std::int64_t origin_us = kind == ClockKind::kVirtual ? 0 : clock.now_us(clock.self) + 20'000;
  // Under the monotonic clock the scene runs ten times as fast: its times are squeezed into the ticks.
  const std::int64_t squeeze = kind == ClockKind::kVirtual ? 1 : 10;
  REQUIRE(engine->start(kind, origin_us + kStep_us / squeeze).ok());
  for (Fed& f : fed) {
    for (auto& e : f.events) e.t_us = origin_us + e.t_us / squeeze;
    for (auto& e : f.poses) e.t_us = origin_us + e.t_us / squeeze;
    for (auto& e : f.odometry) e.t_us = origin_us + e.t_us / squeeze;
    for (auto& e : f.imu) e.t_us = origin_us + e.t_us / squeeze;
  }

  std::uint64_t with_depth = 0;
  std::int64_t fed_until = 0;
  arm();
  for (int ticks = 0; ticks < kTicks; ++ticks) {
    // A tick that was skipped has its samples fed all the same.
    const std::int64_t tick = (engine->next_tick_us() - origin_us) * squeeze / kStep_us;
    for (; fed_until < tick; ++fed_until) {
      const Fed& f = fed[static_cast<std::size_t>(fed_until) % fed.size()];
      engine->inlets().push(f.events);
      engine->inlets().push(f.poses);
      engine->inlets().push(f.odometry);
      engine->inlets().push(f.imu);
    }
    // Where the grid has it anyway; refused under the monotonic clock.
    static_cast<void>(engine->set_next_tick(engine->next_tick_us()));
    static_cast<void>(engine->tick());
    DepthFrame frame;
    static_cast<void>(engine->newest(frame));
    with_depth += frame.votes > 0;
    static_cast<void>(engine->health());
  }
  disarm();
  const Health health = engine->health();
  engine->stop();
  INFO("threads " << threads << ", clock " << static_cast<int>(kind) << ", backend "
                  << static_cast<int>(backend));
  CHECK(allocations == 0);
  CHECK(releases == 0);
  CHECK(locks == 0);
  CHECK(exceptions == 0);
  CHECK(health.ticks.run == kTicks);
  WARN("threads " << threads << ", " << (kind == ClockKind::kVirtual ? "virtual" : "monotonic") << " clock: "
                  << with_depth << " of 1000 ticks with depth, " << health.ticks.skipped << " skipped");
  CHECK(with_depth > (kind == ClockKind::kVirtual ? 900u : 0u));
}
