// What one call of a decoder did.
#pragma once

#include <cstddef>

namespace egofocus {

struct Decoded {
  std::size_t consumed = 0;
  std::size_t produced = 0;
};

}  // namespace egofocus
