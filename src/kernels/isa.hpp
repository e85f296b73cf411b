// Which instruction sets this machine has. Asked once, at set-up; a mask lowers the answer (tests,
// Config::isa_mask). Thread: any. RT: set-up only.
#pragma once

#include <cstdint>

namespace egofocus {

/// Bit numbers of Config::isa_mask: they never change meaning. Lowest first within a family.
enum class Isa : std::uint8_t {
  kScalar = 0,
  kSse41 = 1,
  kAvx2 = 2,
  kAvxVnni = 3,
  kAvx512 = 4,
  kAvx512Vnni = 5,
  kNeon = 8,
  kNeonDot = 9,
  kNeonMm = 10,
};

inline constexpr Isa kEveryIsa[] = {Isa::kScalar,     Isa::kSse41, Isa::kAvx2,    Isa::kAvxVnni, Isa::kAvx512,
                                    Isa::kAvx512Vnni, Isa::kNeon,  Isa::kNeonDot, Isa::kNeonMm};

/// One bit per Isa.
using IsaSet = std::uint32_t;

constexpr IsaSet isa_bit(Isa isa) noexcept {
  return IsaSet{1} << static_cast<unsigned>(isa);
}
constexpr bool has_isa(IsaSet set, Isa isa) noexcept {
  return (set & isa_bit(isa)) != 0;
}

/// What the processor has and the operating system saves on a context switch. kScalar is always in it.
/// kAvx512 means F, BW, VL and DQ together; a level comes with the lower ones of its family, but for
/// kAvxVnni, which is no part of the 512-bit ones. kNeonMm: the 8-bit matrix multiplication (I8MM).
IsaSet detect_isa() noexcept;

/// "scalar", "sse41", ...: the suffix of files, symbols, tests and logs. Never null.
const char* isa_name(Isa isa) noexcept;

}  // namespace egofocus
