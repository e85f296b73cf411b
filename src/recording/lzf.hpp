// LZF, the compression of h5py's pictures. Debian's plugin for HDF5 (hdf5-plugin-lzf 3.7.0) is linked against
// nothing and cannot be loaded, so the few lines of the format stand here.
// Format: LibLZF's lzf_d.c describes it: a control byte c; c < 32: c + 1 literal bytes follow; else a copy of
// (c >> 5) + 2 bytes (a length of 7 + 2 is lengthened by the next byte) from ((c & 31) << 8 | byte) + 1 back.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace egofocus::recording {

/// Bytes written to `out`, or nothing if `packed` is damaged or needs more room.
[[nodiscard]] std::optional<std::size_t> unpack_lzf(std::span<const std::uint8_t> packed,
                                                    std::span<std::uint8_t> out) noexcept;

}  // namespace egofocus::recording
