// How sharp each hypothesis is at a cell, against the cell's other hypotheses, as the network is told: one
// row of cells at a time, 32-bit integers alone. docs/integer_model.md, "The network's input", has the
// formulas with all ranges; the names here are its names.
#pragma once

#include <cstdint>
#include <span>

namespace egofocus {

/// Bytes 0..127 mean (byte - kInputZero) steps, of 1/8 for the focus and 1/32 for the context: no instruction
/// set's 8-bit products overflow on them.
inline constexpr std::int32_t kInputZero = 64;

/// The byte of so many steps up or down, saturating.
inline std::uint8_t input_byte(std::uint32_t steps, bool down) noexcept {
  const std::uint32_t most = down ? 64 : 63;
  const auto capped = static_cast<std::int32_t>(steps < most ? steps : most);
  return static_cast<std::uint8_t>(kInputZero + (down ? -capped : capped));
}

/// Fixed point of one support: what the ratio of energy and events needs, by side and floor.
struct SupportScale {
  std::int32_t side = 1;
  std::uint32_t weight = 1;            ///< side^4
  std::uint32_t energy_shift = 0;      ///< a
  std::uint32_t count_shift = 0;       ///< b
  std::uint32_t floor = 0;             ///< n floor_events, times 2^b
  std::uint32_t reciprocal_shift = 0;  ///< c: reciprocals are floor(2^c / D)
  std::uint64_t noise = 0;             ///< N: (q 2^g)^2 = N / mean D
  std::uint32_t noise_shift = 0;       ///< 5 - g: q in 1/32 is the root, times 2^noise_shift
};

/// side: 1, 3, 5 or 7; floor_events_milli: 20..2000.
SupportScale support_scale(std::int32_t side, std::int32_t floor_events_milli) noexcept;

/// floor(2^c / D) of whole groups of supported counts, D = counts 2^b + floor. counts <= 4080 side^4.
void reciprocals(const SupportScale& scale, std::span<const std::uint32_t> counts,
                 std::uint32_t* out) noexcept;

/// Rows of cells are padded to whole groups of this many: no loop over one has a remainder. What stands in
/// the padding is any value that a cell may have, and comes to nothing.
inline constexpr std::size_t kCellGroup = 8;
constexpr std::size_t padded_row(std::size_t width) noexcept {
  return (width + kCellGroup - 1) / kCellGroup * kCellGroup;
}

/// One row of cells: arrays of padded_row(width) values.
struct SharpnessRow {
  std::span<std::uint32_t> mean;  // of R; its sum to begin with
  std::span<std::int32_t> low;    // smallest and largest R; low then holds an output's bytes
  std::span<std::int32_t> high;
  std::span<std::uint32_t> half;    // 2^h / 2
  std::span<std::uint32_t> scale;   // 2^(26 - h)
  std::span<std::uint32_t> square;  // V
  std::span<std::uint32_t> noise;   // q, in 1/32 unit of R
  std::span<std::int16_t> limit;    // deviations from here on saturate
  std::span<std::uint16_t> factor;  // 2^e
  std::span<std::uint16_t> gain;    // G
};

/// q of each cell from the sum of the supported counts over `hypotheses`.
void noise_row(const SupportScale& scale, std::span<const std::uint32_t> count_sum, std::int32_t hypotheses,
               std::span<std::uint32_t> noise) noexcept;

/// Rows of ratio, reciprocal and deviation are padded. ratio: energies [hypotheses][row], turned into R.
/// deviation: scratch of the same size. z_out + k * stride: bytes [width] of hypothesis k; contrast_out:
/// bytes [width]. `row.noise` is noise_row()'s; floor_noise_q20: 2^16..2^23.
void sharpness_row(const SupportScale& scale, std::uint32_t floor_noise_q20, std::int32_t hypotheses,
                   std::span<const std::uint32_t> reciprocal, std::span<std::uint32_t> ratio,
                   std::span<std::int16_t> deviation, const SharpnessRow& row, std::size_t width,
                   std::uint8_t* z_out, std::size_t stride, std::uint8_t* contrast_out) noexcept;

/// log2(1 + events per cell of the support) / 4, the mean over the hypotheses. out: bytes [width].
void density_row(const SupportScale& scale, std::span<const std::uint32_t> count_sum, std::int32_t hypotheses,
                 std::uint8_t* out) noexcept;

}  // namespace egofocus
