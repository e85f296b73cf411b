// The readers' side of the depth memory: whatever lies there, nothing outside it is read and nothing hangs.
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "egofocus/depth_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // At a multiple of 64, and not a byte more than there is: the sanitizer sees the first one beyond. The
  // magic is given, so that the other fields get their turn.
  void* block = nullptr;
  if (posix_memalign(&block, 64, size) != 0) return 0;
  auto* memory = static_cast<unsigned char*>(block);
  std::memcpy(memory, data, size);
  if (size >= 12) {
    const std::uint32_t layout = EGOFOCUS_DEPTH_LAYOUT;
    std::memcpy(memory, EGOFOCUS_DEPTH_MAGIC, 8);
    std::memcpy(memory + 8, &layout, 4);
  }
  egofocus_depth_reader reader;
  if (egofocus_depth_attach(&reader, memory, size) == 0) {
    std::vector<std::uint16_t> inverse_depth(egofocus_depth_pixels(&reader));
    std::vector<std::uint8_t> confidence(egofocus_depth_pixels(&reader));
    egofocus_depth_info info;
    for (int turn = 0; turn < 3; ++turn) {
      static_cast<void>(egofocus_depth_next(&reader, &info, inverse_depth.data(), confidence.data()));
      static_cast<void>(egofocus_depth_newest(&reader, &info, nullptr, nullptr));
    }
  }
  std::free(memory);
  return 0;
}
