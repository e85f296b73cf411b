#include "core/rt_thread.hpp"

#include <sched.h>
#include <sys/mman.h>

#include <cstddef>

namespace egofocus {
namespace {

constexpr std::size_t kTouchedStackBytes = 64 * 1024;

// A first touch later would be a page fault inside a tick.
void touch_stack() noexcept {
  volatile unsigned char page[kTouchedStackBytes];
  for (std::size_t i = 0; i < kTouchedStackBytes; i += 4096) page[i] = static_cast<unsigned char>(i);
  static_cast<void>(page[0]);
}

}  // namespace

std::uint32_t make_this_thread_real_time(const RtThreadConfig& config) noexcept {
  std::uint32_t refused = 0;
  if (config.fifo_priority > 0) {
    sched_param parameters{};
    parameters.sched_priority = config.fifo_priority;
    if (pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) != 0) refused |= kRefusedPriority;
  }
  if (config.cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    if (config.cpu < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(config.cpu), &set);
    if (pthread_setaffinity_np(pthread_self(), sizeof(set), &set) != 0) refused |= kRefusedPin;
  }
  touch_stack();
  return refused;
}

std::uint32_t lock_memory() noexcept {
  return mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0u : static_cast<std::uint32_t>(kRefusedMemoryLock);
}

void* RtThread::enter(void* self) noexcept {
  auto& thread = *static_cast<RtThread*>(self);
  pthread_setname_np(pthread_self(), thread.config_.name);
  static_cast<void>(make_this_thread_real_time(thread.config_));
  thread.run_(thread.self_);
  return nullptr;
}

Status RtThread::start(const RtThreadConfig& config, void (*run)(void*) noexcept, void* self) noexcept {
  if (running_) return {StatusCode::kBadState, "thread started twice"};
  config_ = config;
  run_ = run;
  self_ = self;
  const int error = pthread_create(&thread_, nullptr, enter, this);
  if (error != 0) return {StatusCode::kThread, config.name, error};
  running_ = true;
  return {};
}

void RtThread::join() noexcept {
  if (!running_) return;
  pthread_join(thread_, nullptr);
  running_ = false;
}

}  // namespace egofocus
