#include "kernels/isa.hpp"

#include <catch2/catch.hpp>
#include <cstring>

#include "kernels/kernel_table.hpp"

using namespace egofocus;

TEST_CASE("the scalar set is always there, and names are distinct") {
  REQUIRE(has_isa(detect_isa(), Isa::kScalar));
  for (Isa a : kEveryIsa) {
    for (Isa b : kEveryIsa) REQUIRE((a == b) == (std::strcmp(isa_name(a), isa_name(b)) == 0));
  }
}

TEST_CASE("families do not mix, and a higher level comes with the lower ones") {
  IsaSet x86 = 0;
  for (Isa isa : {Isa::kSse41, Isa::kAvx2, Isa::kAvxVnni, Isa::kAvx512, Isa::kAvx512Vnni})
    x86 |= isa_bit(isa);
  const IsaSet found = detect_isa();
  REQUIRE(((found & x86) == 0 || !has_isa(found, Isa::kNeon)));
  if (has_isa(found, Isa::kAvx512)) REQUIRE(has_isa(found, Isa::kAvx2));
  if (has_isa(found, Isa::kAvx512Vnni)) REQUIRE(has_isa(found, Isa::kAvx512));
  if (has_isa(found, Isa::kAvxVnni)) REQUIRE(has_isa(found, Isa::kAvx2));
  if (has_isa(found, Isa::kAvx2)) REQUIRE(has_isa(found, Isa::kSse41));
  if (has_isa(found, Isa::kNeonMm)) REQUIRE(has_isa(found, Isa::kNeonDot));
  if (has_isa(found, Isa::kNeonDot)) REQUIRE(has_isa(found, Isa::kNeon));
#if defined(__aarch64__)
  REQUIRE(has_isa(found, Isa::kNeon));
#endif
}

TEST_CASE("a mask lowers what is chosen, down to scalar") {
  REQUIRE(select_kernels(0).warp_vote.isa == Isa::kScalar);
  REQUIRE(select_kernels(0).warp_vote.run == &warp_vote_u8_scalar);
  for (Isa isa : kEveryIsa) {
    const KernelTable table = select_kernels(detect_isa() & isa_bit(isa));
    REQUIRE(table.warp_vote.run != nullptr);
    REQUIRE((table.warp_vote.isa == isa || table.warp_vote.isa == Isa::kScalar));
    REQUIRE(table.conv_u8s8.run != nullptr);
    REQUIRE((table.conv_u8s8.isa == isa || table.conv_u8s8.isa == Isa::kScalar));
    REQUIRE(table.depthwise_u8s8.run != nullptr);
    REQUIRE((table.depthwise_u8s8.isa == isa || table.depthwise_u8s8.isa == Isa::kScalar));
    REQUIRE((table.depthwise_u8s8.packing.block_channels > 1) == (table.depthwise_u8s8.isa != Isa::kScalar));
    REQUIRE((table.conv_u8s8.packing.tile_outputs > 1) == (table.conv_u8s8.isa != Isa::kScalar));
  }
#ifdef EGOFOCUS_HAVE_AVX2
  if (has_isa(detect_isa(), Isa::kAvx2)) {
    REQUIRE(select_kernels(isa_bit(Isa::kAvx2) | isa_bit(Isa::kSse41)).warp_vote.isa == Isa::kAvx2);
  }
#endif
#ifdef EGOFOCUS_HAVE_NEON
  if (has_isa(detect_isa(), Isa::kNeon)) REQUIRE(select_kernels(detect_isa()).warp_vote.isa == Isa::kNeon);
#endif
}
