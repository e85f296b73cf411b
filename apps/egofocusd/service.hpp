// The life of the daemon between its start and its end: one loop that never waits for anybody.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "control_server.hpp"
#include "core/clock.hpp"
#include "depth_run.hpp"
#include "depth_server.hpp"
#include "disk_thread.hpp"
#include "health_text.hpp"
#include "recorder.hpp"
#include "signals.hpp"
#include "tick_watch.hpp"

namespace egofocus::daemon {

class Service {
 public:
  /// Takes the sockets, first of all: a second daemon is refused here. Then all that can fail at set-up.
  /// Throws Error.
  explicit Service(const DaemonConfig& config);

  /// Runs until SIGTERM or SIGINT, or the end of the recording. Returns within 200 ms of the signal; does not
  /// return when a tick or the disk takes longer, but ends the process with the same exit code. Throws Error
  /// when the sources cannot be started.
  int run(const Signals& signals);

 private:
  using Run = std::unique_ptr<DepthRun>;

  void wait(const Signals& signals) const;
  void start(Run run);
  void look_at_run();
  void reload();
  void beat();
  void watch();
  int stop();
  std::string answer(std::string_view request);
  [[nodiscard]] HealthText health() const;
  [[nodiscard]] std::int64_t now_us() const { return clock_.now_us(clock_.self); }

  Clock clock_ = monotonic_clock();
  std::int64_t begun_us_ = now_us();
  DaemonConfig config_;
  std::optional<ControlServer> control_;
  std::optional<DepthServer> depth_;
  Recorder recorder_;
  DiskThread disk_;
  std::unique_ptr<DepthMemory> memory_;
  Run run_;
  std::unique_ptr<Setup> fallback_;  // while a reloaded configuration starts: the one before
  TickWatch tick_watch_;
  RunState told_state_ = RunState::kWaiting;
  std::uint64_t told_ticks_ = 0;
  bool is_ready_ = false;
  bool ended_ = false;
  std::int64_t next_beat_us_ = 0;
  std::int64_t next_watch_us_ = 0;
  std::uint64_t reloads_ = 0;
  std::uint64_t reloads_failed_ = 0;
};

}  // namespace egofocus::daemon
