#include "pipeline/regression.hpp"

#include "core/elementary.hpp"
#include "pipeline/fixed_point.hpp"
#include "pipeline/sharpness.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t kMost = 64;         // hypotheses
constexpr std::uint32_t kOnePixel = 8192;  // of an index in 1/256 times a displacement in 1/32 px

}  // namespace

// No entry comes nearer to a half than 1e-3: the exponential's last bits do not matter.
Regression::Regression() noexcept {
  for (std::int32_t n = 0; n < kEntries; ++n)
    exponential_[n] = static_cast<std::uint16_t>(floor_of(65535.0 * exponential(-n / 32.0) + 0.5));
}

void Regression::row(const std::int16_t* head, const std::int16_t* own, const std::uint8_t* shift,
                     std::int32_t width, std::int32_t hypotheses, std::int32_t used, std::uint16_t* index_q8,
                     std::uint8_t* confidence, std::uint16_t* spread_q8) const noexcept {
  for (std::int32_t x = 0; x < width; ++x, head += hypotheses, own += hypotheses) {
    std::int32_t score[kMost];
    std::int32_t most = head[0] + own[0];
    for (std::int32_t k = 0; k < used; ++k) score[k] = head[k] + own[k];
    for (std::int32_t k = 0; k < used; ++k) most = score[k] > most ? score[k] : most;
    std::uint32_t p[kMost];
    for (std::int32_t k = 0; k < used; ++k) {
      const std::int32_t below = most - score[k];
      p[k] = exponential_[below < kEntries ? below : kEntries - 1];
    }
    std::uint32_t weight[kMost] = {};
    std::uint32_t sum = 0;         // at most 64 * 65535
    std::uint32_t all_weight = 0;  // below 2^31
    for (std::int32_t k = 0; k < used; ++k) {
      weight[k] = p[k] * static_cast<std::uint32_t>(8 * k + 1);
      sum += p[k];
      all_weight += weight[k];
    }
    // The weighted median. Its own weight is not 0: without it the sum would not have reached the half.
    std::int32_t middle = 0;
    std::uint32_t before = 0;
    while (2 * (before + weight[middle]) < all_weight) before += weight[middle++];
    const std::uint64_t rest = all_weight - 2 * before;
    const auto share = static_cast<std::int32_t>((256 * rest + weight[middle]) / (2 * weight[middle]));
    const std::int32_t unclamped = 256 * middle - 128 + share;
    const std::int32_t last = 256 * (used - 1);
    const auto index = static_cast<std::uint32_t>(unclamped < 0 ? 0 : (unclamped < last ? unclamped : last));
    std::uint64_t squares = 0;  // at most 64 * 2^16 * 2^28
    for (std::int32_t k = 0; k < used; ++k) {
      const std::uint32_t off =
          static_cast<std::uint32_t>(256 * k) - index;  // or less than 0: its square is the same
      squares += static_cast<std::uint64_t>(p[k]) * (off * off);
    }
    const std::uint32_t spread = floor_square_root_u32(static_cast<std::uint32_t>(squares / sum));
    const std::uint32_t step = shift[x] > kInputZero ? shift[x] - kInputZero : 0u;  // below 2^6
    index_q8[x] = static_cast<std::uint16_t>(index);
    confidence[x] = static_cast<std::uint8_t>(255 * index * step / ((index + spread) * step + kOnePixel));
    const std::uint32_t with_pixel = step > 0 ? spread + kOnePixel / step : 65535u;
    spread_q8[x] = static_cast<std::uint16_t>(with_pixel < 65535 ? with_pixel : 65535u);
  }
}

}  // namespace egofocus
