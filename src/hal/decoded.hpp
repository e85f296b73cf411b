// What one call of a decoder or encoder did.
#pragma once

#include <cstddef>

namespace egofocus {

/// Both count whole items of their span: input taken, output written.
///
/// Decoders of wire formats promise: as long as `produced` is less than the room that was given, all input
/// has been taken and nothing waits inside but a word that is not complete yet. So the input may be cut
/// anywhere, and a caller goes on while the output comes back full. Decoders of text take whole lines only
/// and leave the tail to be brought again.
struct Decoded {
  std::size_t consumed = 0;
  std::size_t produced = 0;
};

}  // namespace egofocus
