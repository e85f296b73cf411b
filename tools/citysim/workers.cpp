#include "citysim/workers.hpp"

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace egofocus::citysim {

struct Workers::Pool {
  std::mutex mutex;
  std::condition_variable wake;
  std::condition_variable done;
  const std::function<void(int)>* body = nullptr;
  int count = 0;
  std::atomic<int> next{0};
  int busy = 0;
  unsigned round = 0;
  bool leave = false;
  std::exception_ptr error;
  std::vector<std::thread> threads;

  void work() {
    for (int i = next.fetch_add(1); i < count; i = next.fetch_add(1)) {
      try {
        (*body)(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        if (!error) error = std::current_exception();
      }
    }
  }

  void serve() {
    unsigned seen = 0;
    for (;;) {
      std::unique_lock lock(mutex);
      wake.wait(lock, [&] { return leave || round != seen; });
      if (leave) return;
      seen = round;
      lock.unlock();
      work();
      lock.lock();
      if (--busy == 0) done.notify_one();
    }
  }
};

Workers::Workers(int threads) : pool_(std::make_unique<Pool>()) {
  for (int i = 1; i < threads; ++i) pool_->threads.emplace_back([this] { pool_->serve(); });
}

Workers::~Workers() {
  {
    const std::lock_guard lock(pool_->mutex);
    pool_->leave = true;
  }
  pool_->wake.notify_all();
  for (std::thread& thread : pool_->threads) thread.join();
}

int Workers::threads() const {
  return static_cast<int>(pool_->threads.size()) + 1;
}

void Workers::for_each(int count, const std::function<void(int)>& body) {
  Pool& pool = *pool_;
  {
    const std::lock_guard lock(pool.mutex);
    pool.body = &body;
    pool.count = count;
    pool.next = 0;
    pool.error = nullptr;
    pool.busy = static_cast<int>(pool.threads.size());
    ++pool.round;
  }
  pool.wake.notify_all();
  pool.work();
  std::unique_lock lock(pool.mutex);
  pool.done.wait(lock, [&] { return pool.busy == 0; });
  if (pool.error) std::rethrow_exception(pool.error);
}

}  // namespace egofocus::citysim
