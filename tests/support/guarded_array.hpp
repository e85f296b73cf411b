// An array that ends where the mapped memory ends: the first element read or written past it is a fault.
#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <type_traits>

namespace egofocus::test {

template <class T>
class GuardedArray {
 public:
  static_assert(std::is_trivially_copyable_v<T>);

  /// Elements are zero. An empty array still has an address: that of the unmapped page.
  explicit GuardedArray(std::size_t size) : size_(size) {
    const std::size_t page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t used = (size * sizeof(T) + page - 1) / page * page;
    mapped_bytes_ = used + page;
    mapping_ = mmap(nullptr, mapped_bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (mapping_ == MAP_FAILED) std::abort();
    std::byte* end = static_cast<std::byte*>(mapping_) + used;
    if (mprotect(end, page, PROT_NONE) != 0) std::abort();
    data_ = reinterpret_cast<T*>(end - size * sizeof(T));
  }
  ~GuardedArray() { munmap(mapping_, mapped_bytes_); }
  GuardedArray(const GuardedArray&) = delete;
  GuardedArray& operator=(const GuardedArray&) = delete;

  T* data() { return data_; }
  std::size_t size() const { return size_; }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  T& operator[](std::size_t i) { return data_[i]; }

 private:
  std::size_t size_;
  std::size_t mapped_bytes_ = 0;
  void* mapping_ = nullptr;
  T* data_ = nullptr;
};

}  // namespace egofocus::test
