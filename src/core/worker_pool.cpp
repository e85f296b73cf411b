#include "core/worker_pool.hpp"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

namespace egofocus {
namespace {

constexpr int kSpins = 4000;                   // some tens of microseconds
constexpr long kFutexTimeoutNs = 100'000'000;  // a lost wake-up could cost this much, never more

void pause_cpu() noexcept {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__) || defined(__arm__)
  __asm__ volatile("yield");
#endif
}

long futex(std::atomic<std::uint32_t>& word, int operation, std::uint32_t value,
           const timespec* timeout) noexcept {
  static_assert(sizeof(word) == sizeof(std::uint32_t));
  return syscall(SYS_futex, reinterpret_cast<std::uint32_t*>(&word), operation | FUTEX_PRIVATE_FLAG, value,
                 timeout, nullptr, 0);
}

}  // namespace

Status WorkerPool::start(int parts, std::int32_t fifo_priority, std::int32_t first_cpu) noexcept {
  if (parts < 1 || parts > kMaxParts) return {StatusCode::kBadThreads, "threads", parts, kMaxParts};
  if (parts_ != 1) return {StatusCode::kBadState, "worker pool started twice"};
  stopping_.store(false, std::memory_order_relaxed);
  epoch_.store(0, std::memory_order_relaxed);
  parts_ = parts;
  for (int i = 1; i < parts; ++i) {
    Worker& worker = workers_[i - 1];
    worker.pool = this;
    worker.part = i;
    const RtThreadConfig config{"egofocus-work", fifo_priority, first_cpu < 0 ? -1 : first_cpu + i};
    if (Status status = worker.thread.start(config, work, &worker); !status.ok()) {
      stop();
      return status;
    }
  }
  return {};
}

void WorkerPool::stop() noexcept {
  stopping_.store(true, std::memory_order_relaxed);
  epoch_.fetch_add(1, std::memory_order_release);
  futex(epoch_, FUTEX_WAKE, kMaxParts, nullptr);
  for (Worker& worker : workers_) worker.thread.join();
  parts_ = 1;
}

void WorkerPool::run(Job job, void* context) noexcept {
  job_ = job;
  context_ = context;
  if (parts_ > 1) {
    pending_.store(static_cast<std::uint32_t>(parts_ - 1), std::memory_order_relaxed);
    // seq_cst here and in wait_while(): either the worker sees the new epoch before it sleeps, or we see the
    // sleeper.
    epoch_.fetch_add(1, std::memory_order_seq_cst);
    wake(epoch_, epoch_sleepers_);
  }
  job(context, 0, parts_);
  for (std::uint32_t left = pending_.load(std::memory_order_acquire); left != 0;
       left = pending_.load(std::memory_order_acquire)) {
    wait_while(pending_, left, pending_sleepers_);
  }
}

void WorkerPool::work(void* self) noexcept {
  const Worker& worker = *static_cast<Worker*>(self);
  WorkerPool& pool = *worker.pool;
  std::uint32_t seen = 0;  // start() runs before the first run(): epoch 0 is "no job yet"
  if (pool.stopping_.load(std::memory_order_relaxed)) return;
  for (;;) {
    while (pool.epoch_.load(std::memory_order_acquire) == seen)
      pool.wait_while(pool.epoch_, seen, pool.epoch_sleepers_);
    ++seen;
    if (pool.stopping_.load(std::memory_order_relaxed)) return;
    pool.job_(pool.context_, worker.part, pool.parts_);
    if (pool.pending_.fetch_sub(1, std::memory_order_seq_cst) == 1)
      pool.wake(pool.pending_, pool.pending_sleepers_);
  }
}

void WorkerPool::wait_while(std::atomic<std::uint32_t>& word, std::uint32_t value,
                            std::atomic<std::uint32_t>& sleepers) noexcept {
  for (int i = 0; i < kSpins; ++i) {
    if (word.load(std::memory_order_acquire) != value) return;
    pause_cpu();
  }
  const timespec timeout{0, kFutexTimeoutNs};
  sleepers.fetch_add(1, std::memory_order_seq_cst);
  if (word.load(std::memory_order_seq_cst) == value) {
    futex_calls_.fetch_add(1, std::memory_order_relaxed);
    futex(word, FUTEX_WAIT, value, &timeout);
  }
  sleepers.fetch_sub(1, std::memory_order_seq_cst);
}

void WorkerPool::wake(std::atomic<std::uint32_t>& word, std::atomic<std::uint32_t>& sleepers) noexcept {
  if (sleepers.load(std::memory_order_seq_cst) == 0) return;
  futex_calls_.fetch_add(1, std::memory_order_relaxed);
  futex(word, FUTEX_WAKE, kMaxParts, nullptr);
}

}  // namespace egofocus
