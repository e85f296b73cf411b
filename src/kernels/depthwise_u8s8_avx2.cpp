#include "kernels/depthwise_u8s8_ymm.inc"

namespace egofocus {
namespace {

/// Bytes up to 127: the sums of two products fit 16 bits.
inline Wide wide_dot4(Wide acc, Wide bytes, Wide weights) noexcept {
  return _mm256_add_epi32(acc, _mm256_madd_epi16(_mm256_maddubs_epi16(bytes, weights), _mm256_set1_epi16(1)));
}

}  // namespace

void depthwise_u8s8_avx2(const DepthwiseU8S8& conv) noexcept {
  depthwise_by_registers(conv);
}

}  // namespace egofocus
