// Input: pairs of 16 bytes; a third of the bits of their steps is used, so that plausible clocks are met
// often.
#include <cstring>

#include "fuzz/fuzz_input.hpp"
#include "hal/clock_map.hpp"

using egofocus::ClockMap;
using fuzz::require;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ClockMap map;
  std::int64_t device_us = 0;
  std::int64_t host_us = 0;
  std::int64_t last_us = INT64_MIN;
  std::uint64_t jumps = 0;
  for (; size >= 9; data += 9, size -= 9) {
    std::uint32_t steps[2];
    std::memcpy(steps, data + 1, sizeof steps);
    const bool wild = data[0] < 4;
    if (wild) {
      std::memcpy(&device_us, data + 1, 8);
    } else {
      device_us = static_cast<std::int64_t>(static_cast<std::uint64_t>(device_us) + steps[0] % 300000);
      host_us = static_cast<std::int64_t>(static_cast<std::uint64_t>(host_us) + steps[0] % 300000 +
                                          steps[1] % 8000) -
                4000;
    }
    map.observe(device_us, host_us);
    if (map.counters().jumps != jumps || wild) last_us = INT64_MIN;
    jumps = map.counters().jumps;
    const std::int64_t mapped_us = map.to_host_us(device_us);
    if (!wild && device_us > -ClockMap::kMaxTimeUs && device_us < ClockMap::kMaxTimeUs &&
        map.counters().outliers == 0)
      require(mapped_us >= last_us);
    last_us = mapped_us;
    require(map.to_host_us(INT64_MIN) <= map.to_host_us(INT64_MAX));
  }
  const auto& n = map.counters();
  require(n.pairs == n.used + n.backwards + n.outliers + n.invalid);
  return 0;
}
