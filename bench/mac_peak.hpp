// What a core's multipliers can do: the multiply-adds of a tier's instructions on registers alone, u8 x s8
// into s32, as many sums as hide the latency. Its pace is the peak that others are measured against.
#pragma once

#include <cstdint>

namespace egofocus::bench {

/// Returns the multiply-adds done.
using MacPeakFunction = std::int64_t(std::int32_t rounds);
extern "C" MacPeakFunction mac_peak_sse41, mac_peak_avx2, mac_peak_avxvnni, mac_peak_avx512vnni;

}  // namespace egofocus::bench
