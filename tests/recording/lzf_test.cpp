#include "recording/lzf.hpp"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

using egofocus::recording::unpack_lzf;

TEST_CASE("LZF: literals, copies that overlap, and damage") {
  const auto unpack = [](std::vector<std::uint8_t> packed, std::size_t room) {
    std::vector<std::uint8_t> out(room);
    const std::optional<std::size_t> size = unpack_lzf(packed, out);
    return size ? std::string(out.begin(), out.begin() + static_cast<std::ptrdiff_t>(*size)) : "damaged";
  };
  CHECK(unpack({2, 'a', 'b', 'c'}, 3) == "abc");
  CHECK(unpack({1, 'a', 'b', 0x20, 1}, 5) == "ababa");       // 3 bytes from 2 back
  CHECK(unpack({0, 'x', 0xe0, 1, 0}, 11) == "xxxxxxxxxxx");  // 9 + 1 bytes from 1 back
  CHECK(unpack({0, 'x', 0xe0, 1, 0}, 10) == "damaged");      // no room
  CHECK(unpack({2, 'a', 'b'}, 9) == "damaged");              // a literal short
  CHECK(unpack({1, 'a', 'b', 0x20, 2}, 9) == "damaged");     // from before the beginning
  CHECK(unpack({1, 'a', 'b', 0x20}, 9) == "damaged");        // no distance
  CHECK(unpack({1, 'a', 'b', 0xe0}, 9) == "damaged");        // no length
  std::vector<std::uint8_t> far(8400);
  for (std::size_t i = 0; i < far.size(); ++i) far[i] = i % 33 == 0 ? 31 : static_cast<std::uint8_t>(i % 251);
  far.resize(33 * 254);                 // 254 literals of 32
  far.insert(far.end(), {0x3f, 0xbf});  // 3 bytes from 8128 back: the very first ones
  CHECK(unpack(far, 9000).substr(8128) == std::string({1, 2, 3}));
}
