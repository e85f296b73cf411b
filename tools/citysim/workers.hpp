// Fork and join: the same small set of threads for every loop of the simulator.
#pragma once

#include <functional>
#include <memory>

namespace egofocus::citysim {

class Workers {
 public:
  /// `threads` >= 1, the caller's own included.
  explicit Workers(int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// body(i) for each i in [0, count), on any thread, in any order; returns when all are done. The first
  /// exception of a body is thrown again here.
  void for_each(int count, const std::function<void(int)>& body);

  [[nodiscard]] int threads() const;

 private:
  struct Pool;
  std::unique_ptr<Pool> pool_;
};

}  // namespace egofocus::citysim
