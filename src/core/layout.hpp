// Our own constant: std::hardware_destructive_interference_size differs between targets and compiler
// versions, and with it every layout and arena size would.
#pragma once

#include <cstddef>

namespace egofocus {
inline constexpr std::size_t kCacheLine = 64;
}
