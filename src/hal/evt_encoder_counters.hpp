// What an encoder could not write.
#pragma once

#include <cstdint>

namespace egofocus {

/// Each event taken is in exactly one of these.
struct EvtEncoderCounters {
  std::uint64_t events = 0;         ///< written
  std::uint64_t not_encodable = 0;  ///< x or y above 2047, t below zero or behind what was written: left out
};

}  // namespace egofocus
