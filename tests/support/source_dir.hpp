// Where the source tree lies. A function, not a macro: test objects do not depend on the path, so a compiler
// cache serves any checkout.
#pragma once

#include <string>

namespace egofocus::test {
std::string source_dir();
}
