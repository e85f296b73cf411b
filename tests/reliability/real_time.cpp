// Ticks on the real clock, beside a loop that only sleeps, with a hog on the other core: how late each wakes,
// and what a tick asks of the system: page faults, allocations, system calls. usage: real_time [--ticks N]
// [--rate HZ] [--threads N] [--priority N] [--cpu C] [--traced N] [--json FILE]
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <fstream>

#include "core/clock.hpp"
#include "core/rt_thread.hpp"
#include "jitter.hpp"
#include "support/allocation_trap.hpp"
#include "support/engine_in_block.hpp"
#include "support/sliding_scene.hpp"
#include "system_calls.hpp"
#include "watched_sleep.hpp"

namespace egofocus::reliability {
namespace {

using test::SlidingScene;

struct Wish {
  int ticks = 20'000;
  double rate_hz = 50;
  int threads = 1;
  int priority = 50;
  int cpu = 0;
  int traced = 200;
  std::string json;
};

struct Cost {
  std::uint64_t page_faults = 0;
  std::uint64_t allocations = 0;
  std::uint64_t locks = 0;
};

Config config_of(const Wish& wish) {
  Config config = SlidingScene::config();
  config.motion.source = MotionSource::kOdometry;
  config.rate.rate_hz = wish.rate_hz;
  config.threads = wish.threads;
  config.real_time = {wish.priority, wish.cpu, true};
  return config;
}

// Ten seconds of samples, again and again, each time with its time.
class Feed {
 public:
  Feed() {
    const SlidingScene scene;
    events_ = scene.events(0, kCycle_us);
    imu_ = SlidingScene::imu(0, kCycle_us);
    odometry_ = SlidingScene::odometry(0, kCycle_us);
  }
  /// All after the last call's time and not after `until_us`. Takes no memory.
  void push(Inlets inlets, std::int64_t until_us) {
    push(inlets, events_, next_event_, until_us);
    push(inlets, imu_, next_imu_, until_us);
    push(inlets, odometry_, next_odometry_, until_us);
  }
  void begin(std::int64_t t_us) { origin_us_ = t_us; }

 private:
  static constexpr std::int64_t kCycle_us = 10'000'000;
  template <typename Sample>
  void push(Inlets& inlets, const std::vector<Sample>& samples, std::uint64_t& next, std::int64_t until_us) {
    for (;; ++next) {
      Sample sample = samples[static_cast<std::size_t>(next % samples.size())];
      sample.t_us += origin_us_ + static_cast<std::int64_t>(next / samples.size()) * kCycle_us;
      if (sample.t_us > until_us) return;
      inlets.push(std::span<const Sample>(&sample, 1));
    }
  }

  std::vector<Event> events_;
  std::vector<ImuSample> imu_;
  std::vector<OdometrySample> odometry_;
  std::uint64_t next_event_ = 0, next_imu_ = 0, next_odometry_ = 0;
  std::int64_t origin_us_ = 0;
};

// Half a period after the ticks, with the same priority on the same core.
struct Control {
  Control(const Wish& wish, std::int64_t first_due_us)
      : due_us(first_due_us),
        period_us(static_cast<std::int64_t>(1e6 / wish.rate_hz)),
        jitter(static_cast<std::size_t>(wish.ticks)),
        left(wish.ticks + kAfter) {}
  static void run(void* self) noexcept {
    auto& c = *static_cast<Control*>(self);
    const Clock clock = monotonic_clock();
    for (; c.left > 0; --c.left, c.due_us += c.period_us) {
      clock.sleep_until_us(clock.self, c.due_us);
      if (c.left > kAfter) c.jitter.add(woke_late_ns());
    }
  }
  static constexpr int kAfter = 5;  // periods, so that no thread ends while allocations are counted
  std::int64_t due_us;
  std::int64_t period_us;
  Jitter jitter;
  int left;
};

std::uint64_t page_faults() {
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  return static_cast<std::uint64_t>(usage.ru_minflt + usage.ru_majflt);
}

// Computes and sweeps memory on every core but the tick's until it is killed.
pid_t start_hog(int cpu) {
  const pid_t hog = ::fork();
  if (hog != 0) return hog;
  cpu_set_t others;
  CPU_ZERO(&others);
  for (long i = 0; i < ::sysconf(_SC_NPROCESSORS_ONLN); ++i)
    if (i != cpu) CPU_SET(static_cast<std::size_t>(i), &others);
  ::sched_setaffinity(0, sizeof others, &others);
  std::vector<unsigned> memory(8u << 20, 1);
  for (volatile unsigned sum = 0;;)
    for (std::size_t i = 0; i < memory.size(); i += 16) sum = sum + (memory[i] += sum);
}

int trace_ticks(const Wish& wish) {
  test::EngineInBlock engine(config_of(wish));
  const Clock clock = monotonic_clock();
  const std::int64_t first_us = clock.now_us(clock.self) + 20'000;
  Feed feed;
  feed.begin(first_us);
  if (!engine.status.ok() || !engine->start(ClockKind::kMonotonic, first_us).ok()) return 1;
  for (int i = 0; i < wish.traced; ++i) {
    feed.push(engine->inlets(), engine->next_tick_us());
    begin_counting();
    static_cast<void>(engine->tick());
    end_counting();
  }
  return 0;
}

struct Outcome {
  explicit Outcome(const Wish& wish, std::int64_t control_due_us)
      : ticks(static_cast<std::size_t>(wish.ticks)), control(wish, control_due_us) {}
  Jitter ticks;
  Control control;
  Cost cost;
  Health health;
  int with_depth = 0;
};

bool run_ticks(const Wish& wish, std::unique_ptr<Outcome>& out) {
  test::EngineInBlock engine(config_of(wish));
  Feed feed;
  const Clock clock = monotonic_clock();
  const std::int64_t period_us = static_cast<std::int64_t>(1e6 / wish.rate_hz);
  const std::int64_t first_us = clock.now_us(clock.self) + 200'000;
  feed.begin(first_us);
  out = std::make_unique<Outcome>(wish, first_us + period_us / 2);
  RtThread control;
  if (!engine.status.ok() ||
      !control.start({"control", wish.priority, wish.cpu}, Control::run, &out->control).ok() ||
      !engine->start(ClockKind::kMonotonic, first_us).ok())
    return false;
  for (int i = 0; i < wish.ticks; ++i) {
    feed.push(engine->inlets(), engine->next_tick_us());
    const std::uint64_t faults = page_faults();
    armed = true;
    const bool ran = engine->tick();
    armed = false;
    out->cost.page_faults += page_faults() - faults;
    DepthFrame frame;
    if (!ran || !engine->newest(frame)) return false;
    out->ticks.add(woke_late_ns());
    out->with_depth += frame.votes > 0 ? 1 : 0;
  }
  out->health = engine->health();
  out->ticks.skip(out->health.ticks.skipped);
  out->cost.allocations = static_cast<std::uint64_t>(allocations + releases);
  out->cost.locks = static_cast<std::uint64_t>(locks);
  control.join();
  return true;
}

int report(const Wish& wish, const Outcome& out, const std::map<std::uint64_t, std::uint64_t>& calls) {
  recording::Json json;
  json.add("rate_hz", wish.rate_hz).add("threads", wish.threads).add("ticks", out.health.ticks.run);
  json.add("ticks_with_depth", out.with_depth).add("refused", out.health.refused);
  json.add("tick", out.ticks.json()).add("control", out.control.jitter.json());
  json.add("page_faults", out.cost.page_faults).add("allocations", out.cost.allocations);
  json.add("locks", out.cost.locks);
  recording::Json in_tick;
  bool is_quiet = !calls.empty() || wish.traced == 0;
  for (const auto& [number, count] : calls) {
    const std::string name = system_call_name(number);
    in_tick.add(name, static_cast<double>(count) / wish.traced);
    is_quiet &= name == "futex" || name == "clock_nanosleep";
  }
  json.add("system_calls_per_tick", in_tick);
  std::puts(json.text().c_str());
  Jitter::print(out.ticks, "tick", out.control.jitter, "control");
  if (!wish.json.empty()) std::ofstream(wish.json) << json.json() << "\n";

  const bool is_free = out.cost.page_faults == 0 && out.cost.allocations == 0 && out.cost.locks == 0;
  if (!is_quiet) std::puts("error: a tick makes other system calls than its sleep and its workers' futex");
  if (!is_free) std::puts("error: a tick takes page faults, allocates or locks");
  if (out.with_depth < wish.ticks / 2) std::puts("error: too few ticks had depth");
  return is_quiet && is_free && out.with_depth >= wish.ticks / 2 ? 0 : 1;
}

}  // namespace
}  // namespace egofocus::reliability

int main(int argc, char** argv) {
  using namespace egofocus::reliability;
  Wish wish;
  bool hog = true;
  CLI::App program("Ticks on the real clock beside a loop that only sleeps.", "real_time");
  program.add_option("--ticks", wish.ticks)->capture_default_str()->check(CLI::Range(10, 10'000'000));
  program.add_option("--rate", wish.rate_hz)->capture_default_str();
  program.add_option("--threads", wish.threads)->capture_default_str();
  program.add_option("--priority", wish.priority, "SCHED_FIFO of both loops; 0: none")->capture_default_str();
  program.add_option("--cpu", wish.cpu, "both loops run there; -1: anywhere")->capture_default_str();
  program.add_option("--traced", wish.traced, "ticks whose system calls are counted first")
      ->capture_default_str();
  program.add_flag("--hog,!--no-hog", hog, "load on the other cores");
  program.add_option("--json", wish.json);
  CLI11_PARSE(program, argc, argv);
  const auto calls = wish.traced > 0 ? count_system_calls([&wish] { return trace_ticks(wish); })
                                     : std::map<std::uint64_t, std::uint64_t>{};
  const pid_t hog_process = hog ? start_hog(wish.cpu) : 0;
  std::unique_ptr<Outcome> outcome;
  const bool ran = run_ticks(wish, outcome);
  if (hog_process > 0) {
    ::kill(hog_process, SIGKILL);
    ::waitpid(hog_process, nullptr, 0);
  }
  if (!ran) {
    std::puts("error: the engine did not run");
    return 1;
  }
  return report(wish, *outcome, calls);
}
