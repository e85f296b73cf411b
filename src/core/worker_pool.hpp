// A fixed pool that runs one job in parts: part 0 on the caller, part i on worker i. Static partition, so
// that who computes what never depends on timing. Waking is a bounded spin, then one counted futex; no lock,
// no queue, no heap.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/layout.hpp"
#include "core/rt_thread.hpp"
#include "egofocus/status.hpp"

namespace egofocus {

class WorkerPool {
 public:
  static constexpr int kMaxParts = 8;
  /// job(context, part, parts) handles its share; shares must not overlap.
  using Job = void (*)(void* context, int part, int parts) noexcept;

  WorkerPool() noexcept = default;
  ~WorkerPool() { stop(); }
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Starts parts - 1 threads. Worker i is pinned to cpu first_cpu + i when first_cpu >= 0. RT: no.
  Status start(int parts, std::int32_t fifo_priority, std::int32_t first_cpu) noexcept;
  void stop() noexcept;

  [[nodiscard]] int parts() const noexcept { return parts_; }

  /// Runs the job and returns when all parts are done; everything they wrote is visible to the caller.
  /// Thread: the one owner. RT: yes.
  void run(Job job, void* context) noexcept;

  /// Futex system calls so far. Thread: any. RT: yes.
  [[nodiscard]] std::uint64_t futex_calls() const noexcept {
    return futex_calls_.load(std::memory_order_relaxed);
  }

 private:
  struct Worker {
    WorkerPool* pool = nullptr;
    int part = 0;
    RtThread thread;
  };
  static void work(void* self) noexcept;
  void wait_while(std::atomic<std::uint32_t>& word, std::uint32_t value,
                  std::atomic<std::uint32_t>& sleepers) noexcept;
  void wake(std::atomic<std::uint32_t>& word, std::atomic<std::uint32_t>& sleepers) noexcept;

  Worker workers_[kMaxParts - 1];
  int parts_ = 1;
  Job job_ = nullptr;
  void* context_ = nullptr;
  alignas(kCacheLine) std::atomic<std::uint32_t> epoch_{0};
  std::atomic<std::uint32_t> epoch_sleepers_{0};
  alignas(kCacheLine) std::atomic<std::uint32_t> pending_{0};
  std::atomic<std::uint32_t> pending_sleepers_{0};
  alignas(kCacheLine) std::atomic<std::uint64_t> futex_calls_{0};
  std::atomic<bool> stopping_{false};
};

}  // namespace egofocus
