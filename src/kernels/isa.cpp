#include "kernels/isa.hpp"

#if defined(__x86_64__) || defined(__i386__)
#include <cpuid.h>
#elif defined(__arm__) || (defined(__aarch64__) && defined(__linux__))
#include <sys/auxv.h>
#endif

namespace egofocus {
namespace {

constexpr bool bit(unsigned word, unsigned index) noexcept {
  return ((word >> index) & 1u) != 0;
}

#if defined(__x86_64__) || defined(__i386__)

/// Which register files the operating system saves: XCR0. Only legal when CPUID says OSXSAVE.
unsigned saved_state() noexcept {
  unsigned low = 0;
  unsigned high = 0;
  __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  return low;
}

IsaSet detect_family() noexcept {
  unsigned eax = 0;
  unsigned ebx = 0;
  unsigned ecx = 0;
  unsigned edx = 0;
  if (__get_cpuid(1, &eax, &ebx, &ecx, &edx) == 0) return 0;
  IsaSet found = 0;
  if (bit(ecx, 19)) found |= isa_bit(Isa::kSse41);
  const bool has_avx = bit(ecx, 27) && bit(ecx, 28);
  if (!has_avx) return found;

  constexpr unsigned kSseAndAvx = 0x06;
  constexpr unsigned kAlsoMasksAndZmm = 0xe6;
  const unsigned saved = saved_state();
  if (__get_cpuid_count(7, 0, &eax, &ebx, &ecx, &edx) == 0) return found;
  const bool has_avx2 = (saved & kSseAndAvx) == kSseAndAvx && bit(ebx, 5);
  if (has_avx2) found |= isa_bit(Isa::kAvx2);
  const bool f_dq_bw_vl = bit(ebx, 16) && bit(ebx, 17) && bit(ebx, 30) && bit(ebx, 31);
  if ((saved & kAlsoMasksAndZmm) == kAlsoMasksAndZmm && f_dq_bw_vl) {
    found |= isa_bit(Isa::kAvx512);
    if (bit(ecx, 11)) found |= isa_bit(Isa::kAvx512Vnni);
  }
  const bool has_subleaf = eax >= 1 && __get_cpuid_count(7, 1, &eax, &ebx, &ecx, &edx) != 0;
  if (has_avx2 && has_subleaf && bit(eax, 4)) found |= isa_bit(Isa::kAvxVnni);
  return found;
}

#elif defined(__aarch64__)

IsaSet detect_family() noexcept {
  IsaSet found = isa_bit(Isa::kNeon);  // part of the baseline
#if defined(__linux__)
  constexpr unsigned kHwcapDotBit = 20;
  constexpr unsigned kHwcap2MatrixBit = 13;
  if (bit(static_cast<unsigned>(getauxval(AT_HWCAP)), kHwcapDotBit)) {
    found |= isa_bit(Isa::kNeonDot);
    if (bit(static_cast<unsigned>(getauxval(AT_HWCAP2)), kHwcap2MatrixBit)) found |= isa_bit(Isa::kNeonMm);
  }
#endif
  return found;
}

#elif defined(__arm__)

IsaSet detect_family() noexcept {
  constexpr unsigned kHwcapNeonBit = 12;
  return bit(static_cast<unsigned>(getauxval(AT_HWCAP)), kHwcapNeonBit) ? isa_bit(Isa::kNeon) : 0;
}

#else

IsaSet detect_family() noexcept {
  return 0;
}

#endif

}  // namespace

IsaSet detect_isa() noexcept {
  return isa_bit(Isa::kScalar) | detect_family();
}

const char* isa_name(Isa isa) noexcept {
  switch (isa) {
    case Isa::kScalar:
      return "scalar";
    case Isa::kSse41:
      return "sse41";
    case Isa::kAvx2:
      return "avx2";
    case Isa::kAvxVnni:
      return "avxvnni";
    case Isa::kAvx512:
      return "avx512";
    case Isa::kAvx512Vnni:
      return "avx512vnni";
    case Isa::kNeon:
      return "neon";
    case Isa::kNeonDot:
      return "neondot";
    case Isa::kNeonMm:
      return "neonmm";
  }
  return "unknown";
}

}  // namespace egofocus
