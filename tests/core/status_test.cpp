#include "egofocus/status.hpp"

#include <catch2/catch.hpp>
#include <string>

using namespace egofocus;

TEST_CASE("a status names what, where and how much") {
  char text[200];
  const Status s(StatusCode::kArenaTooSmall, "arena", 100, 4096);
  CHECK_FALSE(s.ok());
  const std::size_t n = s.describe(text);
  CHECK(std::string(text) ==
        "arena too small: 100 bytes given, 4096 needed. Ask Engine::required_arena() for the size.");
  CHECK(n == std::string(text).size());
}

TEST_CASE("describe never writes past its buffer") {
  const Status s(StatusCode::kParse, "a rather long reason that will not fit", -9223372036854775807LL - 1);
  for (std::size_t size = 0; size < 70; ++size) {
    std::string buffer(size + 1, '~');
    const std::size_t n = s.describe(std::span<char>(buffer.data(), size));
    CHECK(buffer[size] == '~');
    if (size > 0) {
      CHECK(n <= size - 1);
      CHECK(buffer[n] == '\0');
    }
  }
}
