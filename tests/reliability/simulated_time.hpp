// CLOCK_MONOTONIC of this whole program, the engine's included, stands still but for set_time_us(): live
// behaviour (deadlines, lateness, clocks that jump) without waiting, and the same each time.
#pragma once

#include <cstdint>

namespace egofocus::reliability {

void set_time_us(std::int64_t t_us) noexcept;
[[nodiscard]] std::int64_t time_us() noexcept;

}  // namespace egofocus::reliability
