// Every form of the rounding rule against integers alone: binary32 taken apart, products in 64 bits.
#include "kernels/requant.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <vector>

#include "exercised_isas.hpp"
#include "requant_rows.hpp"

using namespace egofocus;
using namespace egofocus::test;

namespace {

struct Row {
  const char* name;
  Isa isa;
  RequantFunction* run;
};

constexpr Row kRows[] = {
#define EGOFOCUS_REQUANT(suffix, isa) {#suffix, Isa::isa, &requant_rows_##suffix},
#include "requant_rows.inc"
#undef EGOFOCUS_REQUANT
};

/// value / 2^shift to the nearest integer, ties to even.
std::uint64_t shifted_even(std::uint64_t value, int shift) {
  if (shift <= 0) return value << -shift;
  if (shift > 63) return 0;  // values below have at most 48 bits: far under one half
  const std::uint64_t floor = value >> shift;
  const std::uint64_t rest = value - (floor << shift);
  const std::uint64_t half = std::uint64_t{1} << (shift - 1);
  return floor + (rest > half || (rest == half && floor % 2 != 0) ? 1 : 0);
}

/// A positive number mantissa * 2^exponent, brought to 24 significant bits, ties to even.
struct Float24 {
  std::uint64_t mantissa;
  int exponent;
};

Float24 float24(std::uint64_t mantissa, int exponent) {
  int bits = 0;
  while (mantissa >> bits != 0) ++bits;
  const int drop = bits > 24 ? bits - 24 : 0;
  return {shifted_even(mantissa, drop), exponent + drop};
}

std::int64_t clamped(std::int64_t value, std::int64_t low, std::int64_t high) {
  return std::max(low, std::min(high, value));
}

std::int64_t expected_s16(std::int32_t acc, float scale) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &scale, sizeof bits);
  const std::uint64_t scale_mantissa = (bits & 0x7fffff) | 0x800000;
  const int scale_exponent = static_cast<int>(bits >> 23) - 127 - 23;
  const std::int64_t wide = acc;
  const Float24 a = float24(static_cast<std::uint64_t>(wide < 0 ? -wide : wide), 0);
  const Float24 p = float24(a.mantissa * scale_mantissa, a.exponent + scale_exponent);
  const std::int64_t rounded = static_cast<std::int64_t>(shifted_even(p.mantissa, -p.exponent));
  return clamped(wide < 0 ? -rounded : rounded, -32768, 32767);
}

void check(const Row& row, const std::vector<std::int32_t>& acc, const std::vector<float>& scale,
           std::int32_t zero) {
  std::vector<std::int16_t> s16(acc.size());
  std::vector<std::uint8_t> u8(acc.size());
  std::vector<std::int8_t> s8(acc.size());
  row.run({acc.data(), scale.data(), static_cast<std::int32_t>(acc.size()), zero, s16.data(), u8.data(),
           s8.data()});
  for (std::size_t i = 0; i < acc.size(); ++i) {
    const std::int64_t r = expected_s16(acc[i], scale[i]);
    const bool same =
        s16[i] == r && u8[i] == clamped(r + zero, 0, 255) && s8[i] == clamped(r + zero, -128, 127);
    if (same) continue;
    CAPTURE(acc[i], scale[i], zero, r, s16[i], static_cast<int>(u8[i]), static_cast<int>(s8[i]));
    REQUIRE(same);
  }
  SUCCEED();
}

float scale_of(std::uint32_t mantissa, int exponent) {
  const std::uint32_t bits = (mantissa & 0x7fffff) | static_cast<std::uint32_t>(exponent + 127) << 23;
  float scale = 0;
  std::memcpy(&scale, &bits, sizeof scale);
  return scale;
}

void pad(std::vector<std::int32_t>& acc, std::vector<float>& scale) {
  while (acc.size() % kRequantStep != 0) {
    acc.push_back(0);
    scale.push_back(0.5f);
  }
}

}  // namespace

TEST_CASE("requant: the oracle itself, on results worked out by hand") {
  REQUIRE(expected_s16(1, 0.5f) == 0);  // ties to even
  REQUIRE(expected_s16(3, 0.5f) == 2);
  REQUIRE(expected_s16(5, 0.5f) == 2);
  REQUIRE(expected_s16(-3, 0.5f) == -2);
  REQUIRE(expected_s16(10, 0.375f) == 4);                       // 3.75
  REQUIRE(expected_s16((1 << 24) + 1, scale_of(0, -24)) == 1);  // the accumulator is rounded first
  REQUIRE(expected_s16(INT32_MIN, 0.5f) == -32768);
  REQUIRE(expected_s16(INT32_MAX, 0.5f) == 32767);
  REQUIRE(expected_s16(65535, 0.5f) == 32767);  // 32767.5 goes to 32768, out of range
}

TEST_CASE("requant: edges of every range, and ties") {
  std::vector<std::int32_t> acc;
  std::vector<float> scale;
  const std::int32_t base[] = {0,     1,       127,     128,     255,     256,    32767,
                               32768, 1 << 22, 1 << 23, 1 << 24, 1 << 25, 1 << 30};
  std::vector<std::int32_t> values = {INT32_MIN, INT32_MIN + 1, INT32_MAX, INT32_MAX - 1, INT32_MAX - 64};
  for (std::int32_t b : base) {
    for (std::int32_t d = -3; d <= 3; ++d) values.insert(values.end(), {b + d, -b + d});
  }
  for (std::int32_t value : values) {
    for (int exponent = -40; exponent < 0; ++exponent) {
      for (std::uint32_t mantissa : {0u, 1u, 0x400000u, 0x2aaaabu, 0x7fffffu}) {
        acc.push_back(value);
        scale.push_back(scale_of(mantissa, exponent));
      }
    }
  }
  pad(acc, scale);
  for (const Row& row : kRows) {
    if (!exercise("requant", row.isa)) continue;
    INFO(row.name);
    for (std::int32_t zero : {0, 1, -1, 127, 128, -128, 255, -255}) check(row, acc, scale, zero);
  }
}

TEST_CASE("requant: random accumulators at scales that hit the output range, and near ties") {
  const std::uint32_t seed = test_seed();
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::vector<std::int32_t> acc;
  std::vector<float> scale;
  while (acc.size() < 200000) {
    const int bits = static_cast<int>(random() % 32);
    const std::int32_t value = static_cast<std::int32_t>(random()) >> bits;
    const int to_output = static_cast<int>(random() % 18);  // |acc * scale| about 2^0 .. 2^17
    const int exponent = static_cast<int>(clamped(to_output - (31 - bits), -40, -1));
    // Few mantissa bits make exact ties; all of them make products that need rounding.
    const std::uint32_t mantissa = static_cast<std::uint32_t>(random());
    acc.push_back(value);
    scale.push_back(scale_of(random() % 2 == 0 ? mantissa : mantissa & 0x700000, exponent));
  }
  pad(acc, scale);
  for (const Row& row : kRows) {
    if (!exercise("requant", row.isa)) continue;
    INFO(row.name);
    for (std::int32_t zero : {0, 128, -7}) check(row, acc, scale, zero);
  }
}
