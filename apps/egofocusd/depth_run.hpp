// One configuration at work: sources, engine, and the thread of its ticks.
#pragma once

#include <sys/mman.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/rt_thread.hpp"
#include "depth_memory.hpp"
#include "descriptor.hpp"
#include "egofocus/engine.hpp"
#include "open_source.hpp"
#include "setup.hpp"

namespace egofocus::daemon {

class DepthRun {
 public:
  enum class State : std::uint8_t { kStarting, kRunning, kEnded, kFailed };

  /// The engine is configured in its arena, nothing runs and no device is opened. Throws Error.
  explicit DepthRun(std::unique_ptr<Setup> setup);
  ~DepthRun();
  DepthRun(const DepthRun&) = delete;
  DepthRun& operator=(const DepthRun&) = delete;

  /// Opens the sources and starts the tick's thread, which publishes into `memory`. Once. Throws Error.
  void start(DepthMemory& memory, Recorder& recorder);

  /// wait_for_reader: the first tick may be. Thread: the service's.
  void let_go() noexcept { may_tick_.store(true, std::memory_order_release); }

  /// The tick's thread ends after the tick that it is in. Thread: any.
  void request_stop() noexcept;

  /// Stops, waits for the end of a tick, and gives the setup back. Nothing may follow but the destructor.
  [[nodiscard]] std::unique_ptr<Setup> end();

  /// Readable after something happened: a tick, or another state. Reading takes it back.
  [[nodiscard]] int happened() const noexcept { return happened_.number(); }
  void forget_happened() noexcept;

  [[nodiscard]] State state() const noexcept { return state_.load(std::memory_order_acquire); }
  /// kFailed: why. Thread: after kFailed was seen.
  [[nodiscard]] const Status& failure() const noexcept { return failure_; }
  [[nodiscard]] std::uint64_t ticks() const noexcept { return ticks_.load(std::memory_order_relaxed); }
  [[nodiscard]] Health health() const noexcept { return engine_.health(); }
  /// What live sources count. Thread: the service's, after start().
  [[nodiscard]] std::vector<DeviceFact> devices() const;
  [[nodiscard]] const char* isa() const noexcept { return engine_.isa(); }
  [[nodiscard]] const Setup& setup() const noexcept { return *setup_; }

 private:
  void work() noexcept;
  void tell(State state) noexcept;
  void tell() noexcept;

  // Pages of its own, which go back to the system with the run: the heap might keep them.
  struct FreeArena {
    std::size_t bytes = 0;
    void operator()(void* block) const { ::munmap(block, bytes); }
  };

  std::unique_ptr<Setup> setup_;
  Descriptor happened_;
  std::unique_ptr<void, FreeArena> arena_;
  OpenSources sources_;
  DepthMemory* memory_ = nullptr;
  Engine engine_;
  std::atomic<State> state_{State::kStarting};
  std::atomic<std::uint64_t> ticks_{0};
  std::atomic<bool> stopping_{false};
  std::atomic<bool> may_tick_{true};
  Status failure_;
  RtThread thread_;  // last: it ends before what it works on
};

}  // namespace egofocus::daemon
