#include "citysim/dvs_noise.hpp"

#include <algorithm>

namespace egofocus::citysim {
namespace {

using sim::Random;

double exponential_gap(Random& random, double rate) {
  return -sim::natural_log(1.0 - random.uniform()) / rate;
}

}  // namespace

DvsNoise::DvsNoise(int width_px, int height_px, const DvsParameters& p, std::uint64_t seed)
    : leak_per_us_(p.leak_hz * 1e-6),
      shot_per_us_(p.shot_noise_hz * 1e-6),
      row_rate_per_us_(width_px * (leak_per_us_ * kMostLeak + shot_per_us_)),
      width_px_(static_cast<std::uint32_t>(width_px)) {
  const auto rows = static_cast<std::size_t>(height_px);
  const std::size_t pixels = width_px_ * rows;
  if (p.leak_hz > 0) {
    Random random(seed, "leak of a pixel");
    leak_factor_.resize(pixels);
    for (float& factor : leak_factor_)
      factor = static_cast<float>(std::clamp(1.0 + p.leak_spread * random.normal(), 0.0, kMostLeak));
  }
  Random clocks(seed, "noise of a row");
  for (std::size_t y = 0; y < rows; ++y) row_clocks.push_back({0, Random(clocks.bits())});

  Random which(seed, "hot pixels");
  for (std::size_t i = 0; i < pixels; ++i) {
    if (i % width_px_ == 0) first_hot_.push_back(hot_.size());
    if (!which.chance(p.hot_pixel_share) || !(p.hot_pixel_hz > 0)) continue;
    Random of_pixel(which.bits());
    const double rate = exponential_gap(of_pixel, 1.0) * p.hot_pixel_hz * 1e-6;
    hot_.push_back({static_cast<std::uint32_t>(i % width_px_), std::max(rate, 1e-12)});
    hot_clocks.push_back({0, of_pixel});
  }
  first_hot_.push_back(hot_.size());
}

void DvsNoise::start(double t_us) {
  for (Clock& clock : row_clocks) {
    clock.next_us = t_us;
    if (row_rate_per_us_ > 0) clock.next_us += exponential_gap(clock.random, row_rate_per_us_);
  }
  for (std::size_t i = 0; i < hot_.size(); ++i)
    hot_clocks[i].next_us = t_us + exponential_gap(hot_clocks[i].random, hot_[i].rate_per_us);
}

void DvsNoise::add_row(int y, double t_us, std::span<const float> light, std::vector<NoiseEvent>& events) {
  const auto row = static_cast<std::size_t>(y);
  const double leak_part = leak_per_us_ * kMostLeak;
  Clock& clock = row_clocks[row];
  while (row_rate_per_us_ > 0 && clock.next_us <= t_us) {
    const std::uint32_t x = clock.random.below(width_px_);
    const double what = clock.random.uniform(0, leak_part + shot_per_us_);
    if (what < leak_part) {
      if (what < leak_per_us_ * static_cast<double>(leak_factor_[row * width_px_ + x]))
        events.push_back({clock.next_us, x, true});
    } else {
      const float lit = light[x] > 0 ? light[x] : 0.0f;
      const auto share = static_cast<double>(kHalfShotLight / (kHalfShotLight + lit));
      if (what - leak_part < shot_per_us_ * share)
        events.push_back({clock.next_us, x, clock.random.chance(0.5)});
    }
    clock.next_us += exponential_gap(clock.random, row_rate_per_us_);
  }
  for (std::size_t i = first_hot_[row]; i < first_hot_[row + 1]; ++i) {
    Clock& hot = hot_clocks[i];
    for (; hot.next_us <= t_us; hot.next_us += exponential_gap(hot.random, hot_[i].rate_per_us))
      events.push_back({hot.next_us, hot_[i].x, hot.random.chance(kHotOnShare)});
  }
}

}  // namespace egofocus::citysim
