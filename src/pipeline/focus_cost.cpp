#include "pipeline/focus_cost.hpp"

#include "core/elementary.hpp"

namespace egofocus {
namespace {

constexpr double kSosaDelta = 0.4;
constexpr double kSoeDelta = 0.1;
constexpr double kSoeLinearFrom = 60.0;  // beyond it the exponential goes on as a straight line
constexpr double kStiMean = 84.0;        // mean of T^2 / 64 for T uniform in -127..127
constexpr std::size_t kExpectedEntries = 8192;
constexpr std::uint32_t kMaxTimedEvents = 4095;  // 12 bits of a packed time sum

double numerator(FocusCost cost, double count) noexcept {
  switch (cost) {
    case FocusCost::kVariance:
      return 4.0 * count * (count - 1.0);
    case FocusCost::kSosa: {
      const double a = 1.0 - exponential(-kSosaDelta);
      return 256.0 * (exponential(-kSosaDelta * count) - 1.0 + a * count);
    }
    case FocusCost::kSoe: {
      const double a = exponential(kSoeDelta) - 1.0;
      const double bent = count < kSoeLinearFrom ? count : kSoeLinearFrom;
      const double e = exponential(kSoeDelta * bent);
      return 16.0 * (e + kSoeDelta * e * (count - bent) - 1.0 - a * count);
    }
    case FocusCost::kGradient:
    case FocusCost::kSti:
      return 0.0;
  }
  return 0.0;
}

double expectation(FocusCost cost, double density) noexcept {
  switch (cost) {
    case FocusCost::kVariance:
      return 4.0 * density * density;
    case FocusCost::kSosa: {
      const double a = 1.0 - exponential(-kSosaDelta);
      return 256.0 * (exponential(-density * a) - 1.0 + a * density);
    }
    case FocusCost::kSoe: {
      const double a = exponential(kSoeDelta) - 1.0;
      return 16.0 * (exponential(density * a) - 1.0 - a * density);
    }
    case FocusCost::kSti:
      return kStiMean * (1.0 - exponential(-density));
    case FocusCost::kGradient:
      return 0.0;
  }
  return 0.0;
}

std::uint32_t rounded(double x) noexcept {
  if (!(x > 0)) return 0;
  return x < 4294967295.0 ? static_cast<std::uint32_t>(floor_of(x + 0.5)) : 4294967295u;
}

}  // namespace

CellGrid cell_grid(const Intrinsics& grid) noexcept {
  return {(grid.width_px + 1) / 2, (grid.height_px + 1) / 2};
}

Status FocusCostPlane::check(const FocusConfig& config) noexcept {
  if (config.cost > FocusCost::kSti) {
    return {StatusCode::kBadFocus, "focus.cost (FocusCost)", static_cast<std::int64_t>(config.cost)};
  }
  if (config.support_cells < 3 || config.support_cells > 15 || config.support_cells % 2 == 0) {
    return {StatusCode::kBadFocus, "focus.support_cells (odd, 3..15)", config.support_cells, 15};
  }
  if (config.min_support_events < 1 || config.min_support_events > 10000) {
    return {StatusCode::kBadFocus, "focus.min_support_events", config.min_support_events, 10000};
  }
  return {};
}

FocusCostPlane::FocusCostPlane(const FocusConfig& config, const Intrinsics& grid, int parts,
                               Arena& arena) noexcept
    : cost_(config.cost), support_(config.support_cells), grid_(grid), cells_(cell_grid(grid)) {
  const auto r2 = static_cast<std::uint32_t>(support_ * support_);
  weight_ = 4 * r2 * r2;
  // The largest numerator of a pixel is 4 * 255 * 254 < 2^18; 2^18 * n has to fit 32 bits.
  while ((static_cast<std::uint64_t>(weight_) << 18) >> numerator_shift_ > 0xffffffffull) ++numerator_shift_;
  while ((static_cast<std::uint64_t>(weight_) * 255) >> table_shift_ >= kExpectedEntries - 1) ++table_shift_;

  const auto pixels = static_cast<std::size_t>(grid.width_px) * static_cast<std::size_t>(grid.height_px);
  per_count_ = arena.array<std::uint32_t>(256);
  expected_ = arena.array<std::uint32_t>(kExpectedEntries);
  for (int i = 0; i < parts; ++i) {
    Scratch& s = scratch_[i];
    s.numerator = arena.array<std::uint32_t>(cells_.size());
    s.counts = arena.array<std::uint32_t>(cells_.size());
    s.swap = arena.array<std::uint32_t>(cells_.size());
    s.row = arena.array<std::uint32_t>(static_cast<std::size_t>(cells_.width));
    if (cost_ == FocusCost::kSti) s.times = arena.array<std::uint32_t>(pixels);
  }
  for (std::size_t i = 0; i < per_count_.size(); ++i)
    per_count_[i] = rounded(numerator(cost_, static_cast<double>(i)));
  const double n = weight_;
  const double entry = static_cast<double>(1u << table_shift_) / n;  // density per table entry
  const double scale = n / static_cast<double>(1u << numerator_shift_);
  for (std::size_t i = 0; i < expected_.size(); ++i) {
    // No exponential of a density that no table entry needs; it would only run out of range.
    const double density = static_cast<double>(i) * entry;
    expected_[i] = rounded(scale * expectation(cost_, density < 256.0 ? density : 256.0));
  }
}

std::uint32_t FocusCostPlane::expected(std::uint32_t counts) const noexcept {
  const std::uint32_t at = counts >> table_shift_;
  const std::uint32_t share = counts & ((1u << table_shift_) - 1);
  const std::int64_t a = expected_[at];
  const std::int64_t b = expected_[at + 1];
  return static_cast<std::uint32_t>(a + (((b - a) * share) >> table_shift_));
}

void FocusCostPlane::compute(const Warp& warp, std::int32_t k, int part, std::span<std::uint16_t> cost_out,
                             std::span<std::uint16_t> density_out) noexcept {
  Scratch& s = scratch_[part];
  switch (cost_) {
    case FocusCost::kGradient:
      gather_gradient(warp.plane(k), s);
      break;
    case FocusCost::kSti:
      gather_times(warp, k, s);
      break;
    default:
      gather_table(warp.plane(k), s);
      break;
  }
  support_sum(s.numerator, s, numerator_shift_);
  support_sum(s.counts, s, 0);
  const bool has_expectation = cost_ != FocusCost::kGradient;
  const bool small_is_sharp = cost_ == FocusCost::kSti;
  const std::uint32_t floor_weight = weight_ / 20;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const std::uint32_t counts = s.counts[i];
    const std::uint32_t j = has_expectation ? expected(counts) : 0;
    const std::uint32_t a = s.numerator[i];
    const std::uint32_t high = small_is_sharp ? j : a;
    const std::uint32_t low = small_is_sharp ? a : j;
    const std::uint64_t net = high > low ? static_cast<std::uint64_t>(high - low) << numerator_shift_ : 0;
    const std::uint64_t cost = net * 256 / (counts + floor_weight);
    cost_out[i] = static_cast<std::uint16_t>(cost < 65535 ? cost : 65535);
    density_out[i] = static_cast<std::uint16_t>(counts * 256ull / weight_);  // counts <= 255 * weight_
  }
}

void FocusCostPlane::gather_gradient(std::span<const std::uint8_t> plane, Scratch& s) const noexcept {
  for (std::uint32_t& v : s.numerator) v = 0;
  for (std::uint32_t& v : s.counts) v = 0;
  const std::int32_t width = grid_.width_px;
  for (std::int32_t y = 0; y < grid_.height_px; ++y) {
    const std::uint8_t* row = plane.data() + static_cast<std::ptrdiff_t>(y) * width;
    const std::uint8_t* above = row - width;
    const std::uint8_t* below = row + width;
    const bool inner_row = y > 0 && y + 1 < grid_.height_px;
    const std::size_t cell_row = static_cast<std::size_t>(y / 2) * static_cast<std::size_t>(cells_.width);
    std::uint32_t* numerators = s.numerator.data() + cell_row;
    std::uint32_t* counts = s.counts.data() + cell_row;
    for (std::int32_t x = 0; x < width; ++x) {
      // At the border a central difference would need a pixel outside: that difference is left out.
      const std::int32_t dx = x > 0 && x + 1 < width ? row[x + 1] - row[x - 1] : 0;
      const std::int32_t dy = inner_row ? below[x] - above[x] : 0;
      numerators[x / 2] += static_cast<std::uint32_t>(dx * dx + dy * dy);
      counts[x / 2] += row[x];
    }
  }
}

void FocusCostPlane::gather_table(std::span<const std::uint8_t> plane, Scratch& s) const noexcept {
  for (std::uint32_t& v : s.numerator) v = 0;
  for (std::uint32_t& v : s.counts) v = 0;
  const std::uint8_t* pixel = plane.data();
  for (std::int32_t y = 0; y < grid_.height_px; ++y) {
    const std::size_t cell_row = static_cast<std::size_t>(y / 2) * static_cast<std::size_t>(cells_.width);
    for (std::int32_t x = 0; x < grid_.width_px; ++x, ++pixel) {
      const std::size_t cell = cell_row + static_cast<std::size_t>(x / 2);
      s.numerator[cell] += per_count_[*pixel];
      s.counts[cell] += *pixel;
    }
  }
}

void FocusCostPlane::gather_times(const Warp& warp, std::int32_t k, Scratch& s) const noexcept {
  for (std::uint32_t& v : s.times) v = 0;
  const LandingLines& lines = warp.lines();
  for (std::int32_t i = 0; i < lines.count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (k >= lines.k_end[at]) continue;
    const std::int32_t u = (lines.u_q16[at] + k * lines.du_q16[at] + 0x8000) >> 16;
    const std::int32_t v = (lines.v_q16[at] + k * lines.dv_q16[at] + 0x8000) >> 16;
    if (u < 0 || u >= grid_.width_px || v < 0 || v >= grid_.height_px) continue;
    std::uint32_t& sum = s.times[static_cast<std::size_t>(v) * static_cast<std::size_t>(grid_.width_px) +
                                 static_cast<std::size_t>(u)];
    if ((sum & kMaxTimedEvents) < kMaxTimedEvents)
      sum += (static_cast<std::uint32_t>(lines.time_u8[at]) << 12) + 1;
  }
  for (std::uint32_t& v : s.numerator) v = 0;
  for (std::uint32_t& v : s.counts) v = 0;
  const std::uint32_t* pixel = s.times.data();
  const std::uint8_t* count = warp.plane(k).data();
  for (std::int32_t y = 0; y < grid_.height_px; ++y) {
    const std::size_t cell_row = static_cast<std::size_t>(y / 2) * static_cast<std::size_t>(cells_.width);
    for (std::int32_t x = 0; x < grid_.width_px; ++x, ++pixel, ++count) {
      const std::uint32_t events = *pixel & kMaxTimedEvents;
      if (events == 0) continue;
      const auto mean = static_cast<std::int32_t>((*pixel >> 12) / events);  // 0..255
      const std::int32_t t = mean - 127 > 127 ? 127 : mean - 127;
      const std::size_t cell = cell_row + static_cast<std::size_t>(x / 2);
      s.numerator[cell] += static_cast<std::uint32_t>(*count) * static_cast<std::uint32_t>((t * t) >> 6);
      s.counts[cell] += *count;
    }
  }
}

// Two box sums of support_ x support_, zero beyond the border. Separable: twice along rows, twice along
// columns. Modular 32-bit arithmetic makes the running sums exact as long as the true sums fit, which
// numerator_shift_ ensures.
void FocusCostPlane::support_sum(std::span<std::uint32_t> values, Scratch& s, int shift) const noexcept {
  const std::int32_t reach = support_ / 2;
  const auto width = cells_.width;
  const auto stride = static_cast<std::size_t>(width);
  const auto along_row = [&](const std::uint32_t* in, std::uint32_t* out) noexcept {
    std::uint32_t sum = 0;
    for (std::int32_t x = 0; x < reach && x < width; ++x) sum += in[x];
    for (std::int32_t x = 0; x < width; ++x) {
      if (x + reach < width) sum += in[x + reach];
      if (x - reach - 1 >= 0) sum -= in[x - reach - 1];
      out[x] = sum;
    }
  };
  for (std::int32_t y = 0; y < cells_.height; ++y) {
    std::uint32_t* row = values.data() + static_cast<std::size_t>(y) * stride;
    along_row(row, s.row.data());
    along_row(s.row.data(), row);
    if (shift > 0) {
      for (std::int32_t x = 0; x < width; ++x) row[x] >>= shift;
    }
  }
  const auto along_columns = [&](const std::uint32_t* in, std::uint32_t* out) noexcept {
    std::uint32_t* sum = s.row.data();
    for (std::int32_t x = 0; x < width; ++x) sum[x] = 0;
    for (std::int32_t y = 0; y < reach && y < cells_.height; ++y) {
      for (std::int32_t x = 0; x < width; ++x)
        sum[x] += in[static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x)];
    }
    for (std::int32_t y = 0; y < cells_.height; ++y) {
      if (y + reach < cells_.height) {
        const std::uint32_t* entering = in + static_cast<std::size_t>(y + reach) * stride;
        for (std::int32_t x = 0; x < width; ++x) sum[x] += entering[x];
      }
      if (y - reach - 1 >= 0) {
        const std::uint32_t* leaving = in + static_cast<std::size_t>(y - reach - 1) * stride;
        for (std::int32_t x = 0; x < width; ++x) sum[x] -= leaving[x];
      }
      std::uint32_t* to = out + static_cast<std::size_t>(y) * stride;
      for (std::int32_t x = 0; x < width; ++x) to[x] = sum[x];
    }
  };
  along_columns(values.data(), s.swap.data());
  along_columns(s.swap.data(), values.data());
}

}  // namespace egofocus
