#include "kernels/conv_u8s8_ymm.inc"
// after it
#include "kernels/conv_u8s8_few_ymm.inc"

namespace egofocus {
namespace {

inline __m256i dot4(__m256i acc, __m256i bytes, __m256i weights) noexcept {
  return _mm256_dpbusd_avx_epi32(acc, bytes, weights);
}

// 16 registers: the sums, a group's weights, one pixel.
constexpr ConvBody kBody{kConvPacking_avxvnni, 8, 2, {widths<12, 1>(), widths<6, 2>()}, EGOFOCUS_LEAVE};

}  // namespace

void conv_u8s8_avxvnni(const ConvU8S8& conv) noexcept {
  if (!conv_by_few(conv, kConvPacking_avxvnni)) conv_by_blocks(conv, kBody);
}

}  // namespace egofocus
