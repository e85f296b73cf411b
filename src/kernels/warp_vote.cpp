#include "kernels/warp_vote.hpp"

namespace egofocus {

std::int64_t warp_vote_u8_scalar(const WarpVote& vote) noexcept {
  std::int64_t landed = 0;
  for (std::int32_t k = vote.k_begin; k < vote.k_begin + vote.k_count; ++k) {
    std::uint8_t* plane = vote.stack + (k - vote.k_begin) * vote.plane_stride;
    for (std::int32_t i = 0; i < vote.n; ++i) {
      const std::int32_t column = (vote.u_q16[i] + k * vote.du_q16[i] + 0x8000) >> 16;
      const std::int32_t row = (vote.v_q16[i] + k * vote.dv_q16[i] + 0x8000) >> 16;
      if (k >= vote.k_end[i]) continue;
      if (column < 0 || column >= vote.width || row < 0 || row >= vote.height) continue;
      std::uint8_t& cell = plane[row * vote.row_stride + column];
      if (cell < 255) ++cell;
      ++landed;
    }
  }
  return landed;
}

}  // namespace egofocus
