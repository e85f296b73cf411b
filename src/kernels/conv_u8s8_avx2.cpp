#include "kernels/conv_u8s8_ymm.inc"
// after it
#include "kernels/conv_u8s8_few_ymm.inc"

namespace egofocus {
namespace {

/// Bytes up to 127: the sums of two products fit 16 bits.
inline __m256i dot4(__m256i acc, __m256i bytes, __m256i weights) noexcept {
  const __m256i pairs = _mm256_maddubs_epi16(bytes, weights);
  return _mm256_add_epi32(acc, _mm256_madd_epi16(pairs, _mm256_set1_epi16(1)));
}

// 16 registers: the sums, a group's weights, one pixel, the ones, what is between two steps.
constexpr ConvBody kBody{kConvPacking_avx2, 8, 2, {widths<8, 1>(), widths<5, 2>()}, EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_avx2(const ConvU8S8& conv) noexcept {
  if (!conv_by_few(conv, kConvPacking_avx2)) conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
