#include "kernels/requant.hpp"
#include "requant_rows.hpp"

namespace egofocus::test {

void requant_rows_scalar(const RequantArrays& a) {
  for (std::int32_t i = 0; i < a.n; ++i) {
    a.s16[i] = requant_s16(a.acc[i], a.scale[i]);
    a.u8[i] = requant_u8(a.acc[i], a.scale[i], a.zero);
    a.s8[i] = requant_s8(a.acc[i], a.scale[i], a.zero);
  }
}

}  // namespace egofocus::test
