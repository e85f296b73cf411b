// A thread for periodic work: fixed priority, pinned, stack touched beforehand, where the system permits it.
#pragma once

#include <pthread.h>

#include <cstdint>

#include "egofocus/health.hpp"
#include "egofocus/status.hpp"

namespace egofocus {

struct RtThreadConfig {
  const char* name = "egofocus";   ///< at most 15 characters
  std::int32_t fifo_priority = 0;  ///< SCHED_FIFO 1..99; 0 leaves the scheduler as it is
  std::int32_t cpu = -1;           ///< pin; -1 leaves it
};

/// Applies priority and pin to the calling thread and touches its stack. What the system refuses comes back
/// as RealTimeRefusal bits: the work goes on without it. Thread: any. RT: no.
std::uint32_t make_this_thread_real_time(const RtThreadConfig& config) noexcept;

/// Locks the process's memory now and in future (mlockall). Returns kRefusedMemoryLock or 0. RT: no.
std::uint32_t lock_memory() noexcept;

/// start -> run(self) on the new thread -> join. Not copyable, joins in the destructor.
class RtThread {
 public:
  RtThread() noexcept = default;
  ~RtThread() { join(); }
  RtThread(const RtThread&) = delete;
  RtThread& operator=(const RtThread&) = delete;

  /// kThread with errno when the system has no thread to give. RT: no.
  Status start(const RtThreadConfig& config, void (*run)(void* self) noexcept, void* self) noexcept;
  /// Waits for the thread's end; the caller has told it to end. RT: no.
  void join() noexcept;
  [[nodiscard]] bool running() const noexcept { return running_; }

 private:
  static void* enter(void* self) noexcept;

  pthread_t thread_{};
  RtThreadConfig config_;
  void (*run_)(void*) noexcept = nullptr;
  void* self_ = nullptr;
  bool running_ = false;
};

}  // namespace egofocus
