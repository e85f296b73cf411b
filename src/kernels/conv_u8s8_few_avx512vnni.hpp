// The avx512vnni body's way with few outputs (conv_u8s8_few.inc). Inner to it.
#pragma once

#include "kernels/conv_u8s8.hpp"

namespace egofocus {

/// False where the convolution is not one of those; nothing has been done then.
bool conv_u8s8_few_avx512vnni(const ConvU8S8& conv) noexcept;

}  // namespace egofocus
