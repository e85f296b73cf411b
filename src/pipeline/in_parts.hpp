// Lambdas on the worker pool.
#pragma once

#include <cstdint>

#include "core/worker_pool.hpp"

namespace egofocus {

/// step(part, parts) on each part; returns when all are done. Thread: the pool's owner. RT: yes.
template <typename Step>
void in_parts(WorkerPool& pool, const Step& step) noexcept {
  struct Context {
    const Step& step;
  } context{step};
  pool.run(
      [](void* self, int part, int parts) noexcept { static_cast<const Context*>(self)->step(part, parts); },
      &context);
}

/// step(first, rows) on each part: its share of `height` rows. Thread: the pool's owner. RT: yes.
template <typename Step>
void by_rows(WorkerPool& pool, std::int32_t height, const Step& step) noexcept {
  in_parts(pool, [&](int part, int parts) noexcept {
    const std::int32_t first = height * part / parts;
    step(first, height * (part + 1) / parts - first);
  });
}

}  // namespace egofocus
