// The trap: between two marks, no thread of this program may allocate, lock or throw. The functions
// themselves are replaced here; each counts when the trap is armed and then does its work. Included by one
// file of a program.
#pragma once

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>

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

namespace {

[[maybe_unused]] void arm() {
  allocations = releases = locks = exceptions = 0;
  armed = true;
}
[[maybe_unused]] void disarm() {
  armed = false;
}

[[maybe_unused]] bool trapping() {
  if (EGOFOCUS_TRAP == 0) std::puts("skipped: a sanitizer owns malloc and the locks here");
  return EGOFOCUS_TRAP != 0;
}

}  // namespace
