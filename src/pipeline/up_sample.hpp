// Up-sampling by 2 of docs/integer_model.md: 9 a + 3 b + 3 c + d of the four nearest inputs, in sixteenths,
// half up; borders repeated. Output row y, even or odd, of a map at half its size.
#pragma once

#include <cstdint>

namespace egofocus {

/// from: [height][width][channels] at half the size. write(x, c, value) for x < out_width, c < channels.
/// (out_width + 1) / 2 == width; y / 2 < height. kChannels: the channels, where they are known to the
/// caller's text; 0 else. Thread: any. RT: yes.
template <std::int32_t kChannels = 0, typename Value, typename Write>
void up_sample_row(const Value* from, std::int32_t width, std::int32_t height, std::int32_t channels,
                   std::int32_t y, std::int32_t out_width, const Write& write) noexcept {
  const std::int32_t step = kChannels > 0 ? kChannels : channels;
  std::int32_t beside = y % 2 == 0 ? y / 2 - 1 : y / 2 + 1;
  if (beside < 0 || beside >= height) beside = y / 2;
  const Value* const near_row = from + static_cast<std::int64_t>(y / 2) * width * step;
  const Value* const far_row = from + static_cast<std::int64_t>(beside) * width * step;
  const auto pixel = [&](std::int32_t x, std::int32_t own, std::int32_t other) noexcept {
    const Value* const a = near_row + own * step;
    const Value* const b = near_row + other * step;
    const Value* const c = far_row + own * step;
    const Value* const d = far_row + other * step;
    for (std::int32_t i = 0; i < step; ++i) write(x, i, (9 * a[i] + 3 * b[i] + 3 * c[i] + d[i] + 8) >> 4);
  };
  const std::int32_t last = width - 1;
  pixel(0, 0, 0);
  if (out_width > 1) pixel(1, 0, last > 0 ? 1 : 0);
  for (std::int32_t x = 1; x < last; ++x) {
    pixel(2 * x, x, x - 1);
    pixel(2 * x + 1, x, x + 1);
  }
  if (last == 0) return;
  pixel(2 * last, last, last - 1);
  if (2 * last + 1 < out_width) pixel(2 * last + 1, last, last);
}

}  // namespace egofocus
