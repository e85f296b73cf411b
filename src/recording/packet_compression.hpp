// The compressions of AEDAT4 packets, each packet a whole LZ4 or Zstandard frame.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace egofocus::recording {

/// As in the file's header.
enum class Compression : std::int32_t { kNone = 0, kLz4 = 1, kLz4High = 2, kZstd = 3, kZstdHigh = 4 };

/// A packet larger than this, unpacked, cannot be: it would hold ten million events.
inline constexpr std::size_t kLargestPacketBytes = std::size_t{1} << 28;

/// Replaces the content of `out`. `where` is for the message. Throws Error: kBadFile when the frame is
/// damaged, cut off or too large; kFile when this build lacks the library.
void unpack(Compression compression, std::span<const std::byte> packed, const std::string& where,
            std::vector<std::byte>& out);

}  // namespace egofocus::recording
