#include "support/source_dir.hpp"

namespace egofocus::test {
std::string source_dir() {
  return EGOFOCUS_SOURCE_DIR;
}
}  // namespace egofocus::test
