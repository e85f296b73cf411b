// Up-sampling by 2 of docs/integer_model.md: 9 a + 3 b + 3 c + d of the four nearest inputs, in sixteenths,
// half up; borders repeated. Output row y, even or odd, of a map at half its size.
#pragma once

#include <cstdint>

namespace egofocus {

/// from: [height][width][channels] at half the size. write(x, c, value) for x < out_width, c < channels.
/// (out_width + 1) / 2 == width; y / 2 < height. Thread: any. RT: yes.
template <typename Value, typename Write>
void up_sample_row(const Value* from, std::int32_t width, std::int32_t height, std::int32_t channels,
                   std::int32_t y, std::int32_t out_width, const Write& write) noexcept {
  const auto beside = [](std::int32_t at, std::int32_t size) noexcept {
    const std::int32_t other = at % 2 == 0 ? at / 2 - 1 : at / 2 + 1;
    return other < 0 ? 0 : (other < size ? other : size - 1);
  };
  const Value* const near_row = from + static_cast<std::int64_t>(y / 2) * width * channels;
  const Value* const far_row = from + static_cast<std::int64_t>(beside(y, height)) * width * channels;
  for (std::int32_t x = 0; x < out_width; ++x) {
    const std::int32_t own = x / 2 * channels;
    const std::int32_t other = beside(x, width) * channels;
    const Value* const a = near_row + own;
    const Value* const b = near_row + other;
    const Value* const c = far_row + own;
    const Value* const d = far_row + other;
    for (std::int32_t i = 0; i < channels; ++i) write(x, i, (9 * a[i] + 3 * b[i] + 3 * c[i] + d[i] + 8) >> 4);
  }
}

}  // namespace egofocus
