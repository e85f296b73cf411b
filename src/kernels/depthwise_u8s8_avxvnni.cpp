#include "kernels/depthwise_u8s8_ymm.inc"

namespace egofocus {
namespace {

inline Wide wide_dot4(Wide acc, Wide bytes, Wide weights) noexcept {
  return _mm256_dpbusd_avx_epi32(acc, bytes, weights);
}

}  // namespace

void depthwise_u8s8_avxvnni(const DepthwiseU8S8& conv) noexcept {
  depthwise_by_registers(conv);
}

}  // namespace egofocus
