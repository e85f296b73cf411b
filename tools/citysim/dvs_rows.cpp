// A row of pixels from one view to the next.
#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <tuple>

#include "citysim/dvs_state.hpp"

namespace egofocus::citysim {
namespace {

constexpr double kTwoPi = 6.28318530717958647693;
constexpr std::size_t kFew = 40;  // sorted by insertion: no memory is asked for
constexpr std::size_t kScan = 8;  // marks looked at together

Level random_threshold(double nominal, double spread, sim::Random& random) {
  const double factor = std::clamp(1.0 + spread * random.coarse_normal(), 0.2, 5.0);
  return static_cast<Level>(nominal * factor * static_cast<double>(kLevelOne));
}

std::uint64_t hash_of(int width_px, int height_px, const DvsParameters& parameters, std::uint64_t seed) {
  std::uint64_t hash = sim::mix_bits(seed);
  hash = sim::mix_bits(hash ^ static_cast<std::uint64_t>(width_px));
  hash = sim::mix_bits(hash ^ static_cast<std::uint64_t>(height_px));
  for (const NamedValue& p : describe(parameters))
    hash = sim::mix_bits(hash ^ std::bit_cast<std::uint64_t>(p.value));
  return hash;
}

}  // namespace

Dvs::State::State(int width, int height, const DvsParameters& p, std::uint64_t seed)
    : width_px(width),
      height_px(height),
      parameters(p),
      fingerprint(hash_of(width, height, p, seed)),
      filtered(p.bandwidth_hz > 0),
      noise(width, height, p, seed),
      readout(p.readout_events_per_s, p.readout_queue_events),
      phases(seed, "phase of a pixel") {
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  log.resize(pixels);
  if (filtered) level.resize(pixels);
  upper.resize(pixels);
  lower.resize(pixels);
  blocked_until_us.resize(pixels, std::numeric_limits<double>::lowest());
  last_stamp_us.resize(pixels, 0);
  sim::Random thresholds(seed, "threshold of a pixel");
  for (std::size_t i = 0; i < pixels; ++i) {
    on.push_back(random_threshold(p.threshold_on, p.threshold_spread, thresholds));
    off.push_back(random_threshold(p.threshold_off, p.threshold_spread, thresholds));
  }
  sim::Random rows(seed, "latency of a row");
  for (int y = 0; y < height; ++y) latency.emplace_back(rows.bits());
}

void Dvs::State::begin(const LightView& view) {
  log_levels(view.light.data(), static_cast<float>(parameters.dark_light), static_cast<int>(log.size()),
             log.data());
  if (filtered) level = log;
  for (std::size_t i = 0; i < log.size(); ++i) {
    Level last = log[i];  // where the pixel's last event was
    if (settled) {
      const auto range = static_cast<double>(on[i]) + static_cast<double>(off[i]);
      last += static_cast<Level>(range * phases.uniform() - static_cast<double>(on[i]));
    }
    upper[i] = last + on[i];
    lower[i] = last - off[i];
  }
  noise.start(0);
  start_us = now_us = view.t_us;
  has_view = true;
}

void Dvs::State::show_row(int y, std::int64_t from_us, const LightView& view, Band& band) {
  const int n = width_px;
  const auto width = static_cast<std::size_t>(n);
  const std::size_t row = static_cast<std::size_t>(y) * width;
  const auto until_us = static_cast<double>(view.t_us - start_us);
  const double span_us = until_us - static_cast<double>(from_us);
  const float* light = view.light.data() + row;
  band.log1.resize(width);
  band.level1.resize(width);
  band.marked.resize((width + kScan - 1) / kScan * kScan);

  LowPassRate rate;
  log_levels(light, static_cast<float>(parameters.dark_light), n, band.log1.data());
  if (filtered) {
    const double k_per_hz = kTwoPi * 1e-6 * span_us;
    rate.k_dark = static_cast<float>(parameters.bandwidth_floor_hz * k_per_hz);
    rate.k_light = static_cast<float>((parameters.bandwidth_hz - parameters.bandwidth_floor_hz) * k_per_hz);
    low_pass_levels(light, rate, &log[row], band.log1.data(), &level[row], n, band.level1.data());
    mark_crossed(&log[row], band.log1.data(), &level[row], band.level1.data(), &upper[row], &lower[row], n,
                 band.marked.data());
  } else {
    mark_crossed(band.log1.data(), &upper[row], &lower[row], n, band.marked.data());
  }

  band.raised.clear();
  for (std::size_t x = 0; x < width; x += kScan) {
    std::uint64_t any = 0;
    std::memcpy(&any, &band.marked[x], sizeof any);
    for (std::size_t i = x; any != 0 && i < std::min(x + kScan, width); ++i) {
      if (band.marked[i]) look_closer(row, i, from_us, filtered ? rate.of(light[i]) : -1.0f, span_us, band);
    }
  }
  std::copy(band.log1.begin(), band.log1.end(), log.begin() + static_cast<std::ptrdiff_t>(row));
  if (filtered)
    std::copy(band.level1.begin(), band.level1.end(), level.begin() + static_cast<std::ptrdiff_t>(row));

  band.noise.clear();
  noise.add_row(y, until_us, {light, width}, band.noise);
  for (const NoiseEvent& event : band.noise) band.raised.push_back({event.t_us, event.x, event.on, true});
  if (!band.raised.empty()) send(y, band);
}

void Dvs::State::look_closer(std::size_t row, std::size_t x, std::int64_t from_us, float k, double span_us,
                             Band& band) {
  const std::size_t i = row + x;
  LevelStep step;
  step.log0 = log[i];
  step.log1 = band.log1[x];
  step.level0 = filtered ? level[i] : log[i];
  step.level1 = filtered ? band.level1[x] : band.log1[x];
  step.k = static_cast<double>(k);
  step.span_us = span_us;
  Comparators comparators{upper[i], lower[i], on[i], off[i]};
  band.crossings.clear();
  find_crossings(step, comparators, band.crossings);
  upper[i] = comparators.upper;
  lower[i] = comparators.lower;
  for (const Crossing& crossing : band.crossings) {
    const double after_us = std::clamp(crossing.after_us, 0.0, span_us);
    band.raised.push_back(
        {static_cast<double>(from_us) + after_us, static_cast<std::uint32_t>(x), crossing.on, false});
  }
}

void Dvs::State::send(int y, Band& band) {
  const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_px);
  sim::Random& random = latency[static_cast<std::size_t>(y)];
  // A pixel's own crossings are in order already, also where two have the same time.
  const auto earlier = [](const Raised& a, const Raised& b) {
    return std::tie(a.t_us, a.x) < std::tie(b.t_us, b.x);
  };
  if (band.raised.size() > kFew) {
    std::stable_sort(band.raised.begin(), band.raised.end(), earlier);
  } else {
    for (std::size_t i = 1; i < band.raised.size(); ++i) {
      const Raised moved = band.raised[i];
      std::size_t to = i;
      for (; to > 0 && earlier(moved, band.raised[to - 1]); --to) band.raised[to] = band.raised[to - 1];
      band.raised[to] = moved;
    }
  }
  for (const Raised& raised : band.raised) {
    const std::size_t i = row + raised.x;
    if (raised.t_us < blocked_until_us[i]) {
      ++band.counters.refractory_dropped;
      continue;
    }
    blocked_until_us[i] = raised.t_us + parameters.refractory_us;
    ++(raised.noise ? band.counters.noise_events : band.counters.signal_events);
    double late_us = raised.noise ? 0 : parameters.latency_us;
    if (!raised.noise && parameters.latency_jitter_us > 0)
      late_us = std::max(0.0, late_us + parameters.latency_jitter_us * random.coarse_normal());
    // Jitter must not turn a pixel's events around.
    const std::int64_t stamp_us =
        std::max(static_cast<std::int64_t>(raised.t_us + late_us), last_stamp_us[i]);
    last_stamp_us[i] = stamp_us;
    band.events.push_back(event_key(stamp_us, i, raised.on));
  }
}

}  // namespace egofocus::citysim
