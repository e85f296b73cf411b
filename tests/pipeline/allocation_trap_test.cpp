// The trap: between two marks, no thread of this program may allocate, lock or throw. The functions
// themselves are replaced here; each counts when the trap is armed and then does its work.
//
// Source threads belong to the caller and may do as they like, so this program feeds spans instead.
#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <vector>

#include "core/clock.hpp"
#include "core/worker_pool.hpp"
#include "support/engine_in_block.hpp"
#include "support/network_vectors.hpp"
#include "support/sliding_scene.hpp"
#include "support/source_dir.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define EGOFOCUS_TRAP 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define EGOFOCUS_TRAP 0
#endif
#endif
#ifndef EGOFOCUS_TRAP
#define EGOFOCUS_TRAP 1
#endif

namespace {

std::atomic<bool> armed{false};
std::atomic<long> allocations{0};
std::atomic<long> releases{0};
std::atomic<long> locks{0};
std::atomic<long> exceptions{0};

}  // namespace

#if EGOFOCUS_TRAP

namespace {

void count(std::atomic<long>& counter) noexcept {
  if (armed.load(std::memory_order_relaxed)) counter.fetch_add(1, std::memory_order_relaxed);
}

// The next definition of a function behind ours. Looked up before the trap is armed for the first time.
template <typename Function>
Function* next(const char* name) noexcept {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

// glibc's own names for what malloc and its family do: no look-up, which would allocate by itself.
extern "C" {
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t n, std::size_t bytes);
void* __libc_realloc(void* block, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
void __libc_free(void* block);

void* malloc(std::size_t bytes) noexcept {
  count(allocations);
  return __libc_malloc(bytes);
}
void* calloc(std::size_t n, std::size_t bytes) noexcept {
  count(allocations);
  return __libc_calloc(n, bytes);
}
void* realloc(void* block, std::size_t bytes) noexcept {
  count(allocations);
  return __libc_realloc(block, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  count(allocations);
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  count(allocations);
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t bytes) noexcept {
  count(allocations);
  *out = __libc_memalign(alignment, bytes);
  return *out == nullptr ? 12 : 0;
}
void free(void* block) noexcept {
  count(releases);
  __libc_free(block);
}

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static const auto real = next<int(pthread_mutex_t*)>("pthread_mutex_lock");
  count(locks);
  return real(mutex);
}
int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  static const auto real = next<int(pthread_cond_t*, pthread_mutex_t*)>("pthread_cond_wait");
  count(locks);
  return real(condition, mutex);
}
int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex, const timespec* until) {
  static const auto real =
      next<int(pthread_cond_t*, pthread_mutex_t*, const timespec*)>("pthread_cond_timedwait");
  count(locks);
  return real(condition, mutex, until);
}

// Under another name: the compiler has its own, unwritten declaration of this one.
[[noreturn]] void count_throw(void* thrown, void* type, void (*destructor)(void*)) __asm__("__cxa_throw");
void count_throw(void* thrown, void* type, void (*destructor)(void*)) {
  static const auto real = next<void(void*, void*, void (*)(void*))>("__cxa_throw");
  count(exceptions);
  real(thrown, type, destructor);
  std::abort();
}
}

// new and delete of the standard library end in malloc and free, which count; array, aligned and nothrow
// forms too.

#endif

using namespace egofocus;
using test::EngineInBlock;
using test::SlidingScene;

namespace {

void arm() {
  allocations = releases = locks = exceptions = 0;
  armed = true;
}
void disarm() {
  armed = false;
}

bool trapping() {
  if (EGOFOCUS_TRAP == 0) WARN("skipped: a sanitizer owns malloc and the locks here");
  return EGOFOCUS_TRAP != 0;
}

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
