// LZF: the first byte gives the room, the rest is packed.
#include <vector>

#include "fuzz/fuzz_input.hpp"
#include "recording/lzf.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::vector<std::uint8_t> out(std::size_t{data[0]} * 8);
  const std::vector<std::uint8_t> packed(data + 1,
                                         data + size);  // of exactly this size, so that a look beyond is seen
  const auto used = egofocus::recording::unpack_lzf(packed, out);
  fuzz::require(!used || *used <= out.size());
  return 0;
}
