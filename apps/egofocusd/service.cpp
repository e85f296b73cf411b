#include "service.hpp"

#include <poll.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <vector>

#include "log.hpp"
#include "notify.hpp"
#include "recording/error.hpp"
#include "recording/json.hpp"

namespace egofocus::daemon {
namespace {

using recording::Error;
using recording::ExitCode;
using recording::Json;

constexpr std::int64_t kBeat_us = 1'000'000;
constexpr int kLongestWait_ms = 100;
constexpr int kStopTick_ms = 80;  // together well below the 200 ms that are promised
constexpr int kStopDisk_ms = 40;

std::string done(const char* what) {
  return Json().add("done", what).json();
}

std::string refused(std::string_view why) {
  return Json().add("error", why).json();
}

Error not_started(const Status& failure) {
  char text[320];
  failure.describe(text);
  return {failure.code() == StatusCode::kThread ? ExitCode::kMemory : ExitCode::kFile, "cannot be started",
          text};
}

// What sockets and threads were made with at the start stays as it is.
void check_same(const DaemonConfig& now, const DaemonConfig& next) {
  const bool same = now.depth.socket == next.depth.socket && now.depth.group == next.depth.group &&
                    now.control.socket == next.control.socket && now.control.group == next.control.group &&
                    now.metrics.file == next.metrics.file && now.record.folder == next.record.folder &&
                    now.record.buffer_events == next.record.buffer_events &&
                    now.record.max_mib == next.record.max_mib;
  if (!same) {
    throw Error(ExitCode::kConfiguration, next.file.string(),
                "sockets, [metrics] and [record] cannot change while the daemon runs. Start it again.");
  }
}

}  // namespace

Service::Service(const DaemonConfig& config)
    : config_(config),
      control_(std::in_place, config.control),
      depth_(std::in_place, config.depth),
      recorder_(config.record),
      disk_(config.metrics.file, recorder_) {
  start(std::make_unique<DepthRun>(std::make_unique<Setup>(config)));
}

int Service::run(const Signals& signals) {
  while (!ended_) {
    wait(signals);
    for (int signal = signals.take(); signal != 0; signal = signals.take()) {
      if (signal != SIGHUP) return stop();
      reload();
    }
    look_at_run();
    depth_->serve();
    if (depth_->readers() > 0) run_->let_go();
    control_->serve([this](std::string_view request) { return answer(request); });
    watch();
    beat();
  }
  return stop();
}

// Until something can be read anywhere, or a tenth of a second.
void Service::wait(const Signals& signals) const {
  std::vector<pollfd> watched{{signals.number(), POLLIN, 0}, {run_->happened(), POLLIN, 0}};
  depth_->add_to(watched);
  control_->add_to(watched);
  ::poll(watched.data(), watched.size(), kLongestWait_ms);
}

void Service::start(Run run) {
  const Setup& setup = run->setup();
  if (memory_ == nullptr || !memory_->fits(setup.grid(), setup.daemon.depth.slots)) {
    auto memory = std::make_unique<DepthMemory>(setup.grid(), setup.daemon.depth.slots);
    depth_->show(memory.get());
    memory_ = std::move(memory);
  }
  run_ = std::move(run);
  tick_watch_.begin(static_cast<std::int64_t>(1e6 / run_->setup().camera.config.rate.rate_hz), now_us());
  is_ready_ = false;
  run_->start(*memory_, recorder_);
}

void Service::look_at_run() {
  run_->forget_happened();
  if (run_->ticks() != told_ticks_) depth_->wake_readers();
  told_ticks_ = run_->ticks();
  switch (run_->state()) {
    case DepthRun::State::kStarting:
      break;
    case DepthRun::State::kRunning:
      if (is_ready_) break;
      is_ready_ = true;
      fallback_.reset();
      notify("READY=1\nSTATUS=depth every " +
             std::to_string(static_cast<int>(1000 / run_->setup().camera.config.rate.rate_hz)) + " ms");
      log(Priority::kNotice, "runs with " + run_->setup().daemon.file.string() + ": " + run_->isa());
      break;
    case DepthRun::State::kEnded:
      log(Priority::kNotice, "the recording has ended");
      ended_ = true;
      break;
    case DepthRun::State::kFailed:
      if (fallback_ == nullptr) throw not_started(run_->failure());
      ++reloads_failed_;
      log(Priority::kError,
          std::string(not_started(run_->failure()).what()) + " Back to the old configuration.");
      start(std::make_unique<DepthRun>(std::move(fallback_)));
      break;
  }
}

// Everything that can be known without the devices is found while the old configuration still runs.
void Service::reload() {
  bool old_ended = false;
  try {
    const DaemonConfig config = read_daemon_config(config_.file);
    check_same(config_, config);
    auto next = std::make_unique<DepthRun>(std::make_unique<Setup>(config));
    notify("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(now_us()));
    recorder_.end();
    fallback_ = run_->end();
    old_ended = true;
    start(std::move(next));
    ++reloads_;
  } catch (const std::exception& error) {
    ++reloads_failed_;
    log(Priority::kError, std::string(error.what()) + " Goes on with the old configuration.");
    if (old_ended) start(std::make_unique<DepthRun>(std::move(fallback_)));
    notify("READY=1");
  }
}

void Service::watch() {
  static const std::int64_t period_us = watchdog_period_us();
  if (period_us == 0 || now_us() < next_watch_us_) return;
  next_watch_us_ = now_us() + std::min(period_us, kBeat_us);
  const bool may_wait = run_->state() == DepthRun::State::kStarting;  // systemd bounds the start by itself
  if (may_wait || tick_watch_.is_alive(run_->ticks(), now_us())) notify("WATCHDOG=1");
}

void Service::beat() {
  if (now_us() < next_beat_us_) return;
  next_beat_us_ = now_us() + kBeat_us;
  HealthText text = health();
  recorder_.note_health(text.json);
  disk_.write_metrics(std::move(text.metrics));
  const Health health = run_->health();
  if (health.state == told_state_) return;
  told_state_ = health.state;
  const std::string state = std::string(to_string(health.state)) + ", " + to_string(health.cause);
  notify("STATUS=" + state);
  log(health.state == RunState::kRunning ? Priority::kInfo : Priority::kWarning, "depth: " + state);
}

int Service::stop() {
  notify("STOPPING=1");
  run_->request_stop();
  const bool disk_done = disk_.finish(kStopDisk_ms);
  const std::int64_t until_us = now_us() + kStopTick_ms * 1000;
  const auto still_runs = [this] {
    return run_->state() == DepthRun::State::kRunning || run_->state() == DepthRun::State::kStarting;
  };
  while (still_runs() && now_us() < until_us) {
    run_->forget_happened();
    pollfd happened{run_->happened(), POLLIN, 0};
    ::poll(&happened, 1, 5);
  }
  depth_.reset();
  control_.reset();
  log(Priority::kNotice, disk_done ? "stopped" : "stopped while the disk did not answer");
  // A tick in work is of use to nobody any more, and a disk that hangs may hang for minutes.
  if (still_runs() || !disk_done) std::_Exit(static_cast<int>(ExitCode::kOk));
  return static_cast<int>(ExitCode::kOk);
}

std::string Service::answer(std::string_view request) {
  try {
    if (request == "health") return health().json;
    if (request == "record start") {
      recorder_.begin(run_->setup(), now_us());
      return done("a recording begins");
    }
    if (request == "record stop")
      return recorder_.end() ? done("the recording ends") : refused("no recording is on");
    if (request == "reload") {
      const std::uint64_t failed = reloads_failed_;
      reload();
      return reloads_failed_ == failed ? done("the configuration was read again")
                                       : refused("the configuration is refused; the log says why");
    }
  } catch (const std::exception& error) {
    return refused(error.what());
  }
  return refused("unknown request. There are: health, record start, record stop, reload");
}

HealthText Service::health() const {
  return health_text({.health = run_->health(),
                      .recorder = recorder_.facts(),
                      .devices = run_->devices(),
                      .isa = run_->isa(),
                      .up_s = (now_us() - begun_us_) / 1'000'000,
                      .readers = depth_->readers(),
                      .reloads = reloads_,
                      .reloads_failed = reloads_failed_,
                      .log_lines_left_out = lines_left_out()});
}

}  // namespace egofocus::daemon
