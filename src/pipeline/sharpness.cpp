#include "pipeline/sharpness.hpp"

#include "core/check.hpp"
#include "pipeline/fixed_point.hpp"

namespace egofocus {
namespace {

constexpr std::int32_t kMostRatio = (1 << 26) - (1 << 13);  // 64 of them, or one times 64, fit 32 bits
constexpr std::uint32_t kMostRatioBits = 13;                // so that R saturates at 8191 or beyond
constexpr std::uint32_t kDeviationBits = 13;
constexpr std::int32_t kMostDeviation = 8191;  // 64 of its squares fit 32 bits

// Largest shifts that keep energies (2 * 65535 side^4) and counts (4080 side^4) in 32 bits; the counts'
// leave four bits for remainders.
constexpr std::uint32_t kEnergyShift[4] = {15, 8, 5, 3};
constexpr std::uint32_t kCountShift[4] = {15, 9, 6, 4};

// log2(above / below) / 4 in steps of 1/32
std::uint8_t log_byte(std::uint32_t above_q8, std::uint32_t below_q8) noexcept {
  return input_byte((above_q8 - below_q8 + 16) >> 5, false);
}

// A compiler sees that there is no remainder.
std::size_t whole_groups(std::size_t padded) noexcept {
  return padded / kCellGroup * kCellGroup;
}

// A padded row of bytes before its first `width` leave, where `low` is not needed any more.
std::uint8_t* bytes_of(const SharpnessRow& row) noexcept {
  return reinterpret_cast<std::uint8_t*>(row.low.data());
}

// R of one hypothesis, and its sum, smallest and largest.
void ratios(const SupportScale& scale, const std::uint32_t* reciprocal, std::uint32_t* __restrict ratio,
            const SharpnessRow& row) noexcept {
  const std::size_t width = whole_groups(row.mean.size());
  const std::uint32_t shift = scale.energy_shift;
  std::uint32_t* __restrict const sum = row.mean.data();
  std::int32_t* __restrict const low = row.low.data();
  std::int32_t* __restrict const high = row.high.data();
  for (std::size_t x = 0; x < width; ++x) {
    const auto high_half = static_cast<std::int32_t>(multiply_high_u32(ratio[x] << shift, reciprocal[x]));
    const std::int32_t value = high_half < kMostRatio ? high_half : kMostRatio;
    ratio[x] = static_cast<std::uint32_t>(value);
    sum[x] += static_cast<std::uint32_t>(value);
    low[x] = value < low[x] ? value : low[x];
    high[x] = value > high[x] ? value : high[x];
  }
}

// The mean, and how far deviations are shifted to have at most 13 significant bits: 64 squares of them fit.
// A product with 2^(26 - h) stands for a shift by h, which few vector units have lane by lane.
void centre(std::uint32_t hypotheses, const SharpnessRow& row) noexcept {
  for (std::size_t x = 0; x < row.mean.size(); ++x) {
    const std::uint32_t mean = (row.mean[x] + hypotheses / 2) / hypotheses;
    const std::uint32_t above = static_cast<std::uint32_t>(row.high[x]) - mean;
    const std::uint32_t below = mean - static_cast<std::uint32_t>(row.low[x]);
    const std::uint32_t bits = bit_width_u32(above > below ? above : below);
    const std::uint32_t h = bits > kDeviationBits ? bits - kDeviationBits : 0;
    row.mean[x] = mean;
    row.half[x] = (1u << h) >> 1;
    row.scale[x] = 1u << (26 - h);
    row.square[x] = 0;
  }
}

// u of one hypothesis, and its square into V.
void deviations(const std::uint32_t* ratio, const SharpnessRow& row, std::int16_t* __restrict out) noexcept {
  const std::size_t width = whole_groups(row.mean.size());
  const std::uint32_t* const mean = row.mean.data();
  const std::uint32_t* const half = row.half.data();
  const std::uint32_t* const scale = row.scale.data();
  for (std::size_t x = 0; x < width; ++x) {
    const auto d = static_cast<std::int32_t>(ratio[x] - mean[x]);
    const std::uint32_t size = static_cast<std::uint32_t>(d < 0 ? -d : d) + half[x];
    const auto shifted = static_cast<std::int32_t>(multiply_high_u32(size << 6, scale[x]));
    const std::int32_t u = shifted < kMostDeviation ? shifted : kMostDeviation;
    out[x] = static_cast<std::int16_t>(d < 0 ? -u : u);
  }
  std::uint32_t* __restrict const square = row.square.data();
  for (std::size_t x = 0; x < width; ++x)
    square[x] += static_cast<std::uint32_t>(static_cast<std::int32_t>(out[x]) * out[x]);
}

void divisors(std::uint32_t hypotheses, std::uint32_t floor_noise_q20, const SharpnessRow& row) noexcept {
  const std::size_t width = whole_groups(row.mean.size());
  std::uint32_t* const sd = row.square.data();
  std::uint8_t* const contrast = bytes_of(row);
  for (std::size_t x = 0; x < width; ++x)
    sd[x] = static_cast<std::uint32_t>((static_cast<std::uint64_t>(sd[x]) << 6) / hypotheses);
  for (std::size_t x = 0; x < width; ++x) sd[x] = 4 * floor_square_root_u32(sd[x]);
  for (std::size_t x = 0; x < width; ++x) {
    const std::uint32_t h = 27 - bit_width_u32(row.scale[x]);
    const std::uint32_t q = row.noise[x];
    const std::uint64_t floor_noise = static_cast<std::uint64_t>(q) * floor_noise_q20 + (1u << 19);
    const std::uint32_t divisor = sd[x] + (static_cast<std::uint32_t>(floor_noise >> 20) >> h);
    const std::uint32_t bits = bit_width_u32(divisor);
    const std::uint32_t e = bits < 16 ? 16 - bits : 0;
    const std::uint32_t gain = (1u << 31) / (divisor << e);
    const std::uint32_t limit = divisor >> 2;
    row.factor[x] = static_cast<std::uint16_t>(1u << e);
    row.gain[x] = static_cast<std::uint16_t>(gain < 65535 ? gain : 65535);
    row.limit[x] = static_cast<std::int16_t>(limit < kMostDeviation ? limit : kMostDeviation);
    contrast[x] = log_byte(log2_q8((sd[x] << h) + q), log2_q8(q));
  }
}

// z of one hypothesis, half away from zero.
void quotients(const std::int16_t* u, const SharpnessRow& row) noexcept {
  const std::size_t width = whole_groups(row.mean.size());
  std::uint8_t* __restrict const out = bytes_of(row);
  const std::int16_t* const limit = row.limit.data();
  const std::uint16_t* const factor = row.factor.data();
  const std::uint16_t* const gain = row.gain.data();
  for (std::size_t x = 0; x < width; ++x) {
    const auto size = static_cast<std::int16_t>(u[x] < 0 ? -u[x] : u[x]);
    const std::int16_t near = size < limit[x] ? size : limit[x];
    const auto wide = static_cast<std::uint16_t>(near * factor[x]);
    const auto product = static_cast<std::uint16_t>((static_cast<std::uint32_t>(wide) * gain[x]) >> 16);
    const auto steps = static_cast<std::int16_t>(static_cast<std::uint16_t>(product + 64) >> 7);
    const auto signed_steps = static_cast<std::int16_t>(u[x] < 0 ? -steps : steps);  // -64..64
    out[x] = static_cast<std::uint8_t>(kInputZero + (signed_steps < 63 ? signed_steps : 63));
  }
}

}  // namespace

SupportScale support_scale(std::int32_t side, std::int32_t floor_events_milli) noexcept {
  EGOFOCUS_CHECK(side >= 1 && side <= 7 && side % 2 == 1);
  EGOFOCUS_CHECK(floor_events_milli >= 20 && floor_events_milli <= 2000);
  SupportScale out;
  const auto s = static_cast<std::uint32_t>(side);
  out.side = side;
  out.weight = s * s * s * s;
  out.energy_shift = kEnergyShift[s / 2];
  out.count_shift = kCountShift[s / 2];
  const std::uint64_t pixels = std::uint64_t{16} * out.weight << out.count_shift;  // n 2^b < 2^20
  out.floor =
      static_cast<std::uint32_t>((pixels * static_cast<std::uint32_t>(floor_events_milli) + 500) / 1000);
  const std::uint32_t longest = 30 + bit_width_u32(out.floor);
  const std::uint32_t enough = 32 + kMostRatioBits + out.count_shift - out.energy_shift;
  out.reciprocal_shift = longest < enough ? longest : enough;
  // R has 2^(a + c - 32 - b) per 1; q^2 = 4 n 2^b / (m D) with n / m = 4 side^2 / 9, or 1 without a support.
  const std::uint32_t ratio_bits = out.energy_shift + out.reciprocal_shift - 32 - out.count_shift;
  const std::uint64_t top = s == 1 ? 1 : 4 * s * s;
  const std::uint64_t bottom = s == 1 ? 1 : 9;
  std::uint32_t bits = 2 * ratio_bits + 2 + out.count_shift + 2 * 5;  // g = 5 to begin with
  const auto constant = [&](std::uint32_t shift) { return (top << shift) / bottom; };
  while (bits > 55 || constant(bits) / out.floor > 0xffffffffu) {
    bits -= 2;
    ++out.noise_shift;
  }
  out.noise = constant(bits);
  return out;
}

// Quotients of binary64, truncated: exact, as numerators of 2^46 and less leave no quotient within a rounding
// of the integer above it. Vector units divide these, and 64-bit integers few of them.
void reciprocals(const SupportScale& scale, std::span<const std::uint32_t> counts,
                 std::uint32_t* out) noexcept {
  const auto one = static_cast<double>(std::uint64_t{1} << scale.reciprocal_shift);
  std::uint32_t* __restrict const to = out;
  const std::size_t size = whole_groups(counts.size());
  for (std::size_t i = 0; i < size; ++i) {
    const auto divisor = static_cast<std::int32_t>((counts[i] << scale.count_shift) + scale.floor);  // < 2^28
    to[i] = static_cast<std::uint32_t>(static_cast<std::int64_t>(one / divisor));
  }
}

void noise_row(const SupportScale& scale, std::span<const std::uint32_t> count_sum, std::int32_t hypotheses,
               std::span<std::uint32_t> noise) noexcept {
  const auto k = static_cast<std::uint32_t>(hypotheses);
  const std::size_t width = whole_groups(noise.size());
  const std::uint32_t shift = scale.noise_shift;
  std::uint32_t* const q = noise.data();
  for (std::size_t x = 0; x < width; ++x) {
    const std::uint64_t mean =
        (static_cast<std::uint64_t>(count_sum[x]) << scale.count_shift) / k + scale.floor;
    q[x] = static_cast<std::uint32_t>(scale.noise / static_cast<std::uint32_t>(mean));
  }
  for (std::size_t x = 0; x < width; ++x) q[x] = floor_square_root_u32(q[x]) << shift;
}

void sharpness_row(const SupportScale& scale, std::uint32_t floor_noise_q20, std::int32_t hypotheses,
                   std::span<const std::uint32_t> reciprocal, std::span<std::uint32_t> ratio,
                   std::span<std::int16_t> deviation, const SharpnessRow& row, std::size_t width,
                   std::uint8_t* z_out, std::size_t stride, std::uint8_t* contrast_out) noexcept {
  const std::size_t padded = row.mean.size();
  const auto count = static_cast<std::size_t>(hypotheses);
  EGOFOCUS_CHECK(padded == padded_row(width));
  for (std::size_t x = 0; x < padded; ++x) {
    row.mean[x] = 0;
    row.low[x] = kMostRatio;
    row.high[x] = 0;
  }
  for (std::size_t k = 0; k < count; ++k) ratios(scale, &reciprocal[k * padded], &ratio[k * padded], row);
  centre(static_cast<std::uint32_t>(hypotheses), row);
  for (std::size_t k = 0; k < count; ++k) deviations(&ratio[k * padded], row, &deviation[k * padded]);
  divisors(static_cast<std::uint32_t>(hypotheses), floor_noise_q20, row);
  __builtin_memcpy(contrast_out, bytes_of(row), width);
  for (std::size_t k = 0; k < count; ++k) {
    quotients(&deviation[k * padded], row);
    __builtin_memcpy(z_out + k * stride, bytes_of(row), width);
  }
}

void density_row(const SupportScale& scale, std::span<const std::uint32_t> count_sum, std::int32_t hypotheses,
                 std::uint8_t* out) noexcept {
  const std::uint32_t none = static_cast<std::uint32_t>(hypotheses) * scale.weight;
  const std::uint32_t below_q8 = log2_q8(none);
  for (std::size_t x = 0; x < count_sum.size(); ++x)
    out[x] = log_byte(log2_q8(none + count_sum[x]), below_q8);
}

}  // namespace egofocus
