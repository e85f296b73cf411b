// What one call of a decoder or encoder did.
#pragma once

#include <cstddef>

namespace egofocus {

/// Both count whole items of their span: input taken, output written.
///
/// Every feed() keeps one promise: as long as `produced` is less than the room that was given, all input has been
/// taken and nothing waits inside. So a caller goes on while the output comes back full or input is left, and may
/// cut the input anywhere: a word or line that is not complete waits inside for its rest.
struct Decoded {
  std::size_t consumed = 0;
  std::size_t produced = 0;
};

}  // namespace egofocus
