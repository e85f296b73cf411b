// What an encoder could not write.
#pragma once

#include <cstdint>

namespace egofocus {

/// Each event taken is in exactly one of these.
struct EvtEncoderCounters {
  std::uint64_t events = 0;  ///< written
  std::uint64_t not_encodable =
      0;  ///< left out: x or y above 2047, t below zero, behind what was written, or 2^16 wraps ahead
};

}  // namespace egofocus
