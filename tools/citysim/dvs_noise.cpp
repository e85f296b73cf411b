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
      width_px_(static_cast<std::uint32_t>(width_px)) {
  const auto rows = static_cast<std::size_t>(height_px);
  const std::size_t pixels = width_px_ * rows;
  if (p.leak_hz + p.shot_noise_hz > 0) {
    Random random(seed, "noise of a pixel");
    double sum = 0;
    for (std::size_t i = 0; i < pixels; ++i) {
      const double s = p.noise_spread;
      sum = (i % width_px_ == 0 ? 0 : sum) + exponential(s * random.coarse_normal() - 0.5 * s * s);  // mean 1
      factor_sum_.push_back(sum);
    }
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

double DvsNoise::row_rate(std::size_t row) const {
  return (leak_per_us_ + shot_per_us_) * factor_sum_[(row + 1) * width_px_ - 1];
}

void DvsNoise::start(double t_us) {
  for (std::size_t y = 0; y < row_clocks.size(); ++y) {
    Clock& clock = row_clocks[y];
    clock.next_us = t_us;
    if (!factor_sum_.empty()) clock.next_us += exponential_gap(clock.random, row_rate(y));
  }
  for (std::size_t i = 0; i < hot_.size(); ++i)
    hot_clocks[i].next_us = t_us + exponential_gap(hot_clocks[i].random, hot_[i].rate_per_us);
}

void DvsNoise::add_row(int y, double t_us, std::span<const float> light, std::vector<NoiseEvent>& events) {
  const auto row = static_cast<std::size_t>(y);
  Clock& clock = row_clocks[row];
  while (!factor_sum_.empty() && clock.next_us <= t_us) {
    const double* sums = &factor_sum_[row * width_px_];
    const double* chosen =
        std::upper_bound(sums, sums + width_px_ - 1, clock.random.uniform(0, sums[width_px_ - 1]));
    const auto x = static_cast<std::uint32_t>(chosen - sums);
    const double what = clock.random.uniform(0, leak_per_us_ + shot_per_us_);
    if (what < leak_per_us_) {
      events.push_back({clock.next_us, x, true});
    } else {
      const float lit = light[x] > 0 ? light[x] : 0.0f;
      const auto share = static_cast<double>(kHalfShotLight / (kHalfShotLight + lit));
      if (what - leak_per_us_ < shot_per_us_ * share)
        events.push_back({clock.next_us, x, clock.random.chance(0.5)});
    }
    clock.next_us += exponential_gap(clock.random, row_rate(row));
  }
  for (std::size_t i = first_hot_[row]; i < first_hot_[row + 1]; ++i) {
    Clock& hot = hot_clocks[i];
    for (; hot.next_us <= t_us; hot.next_us += exponential_gap(hot.random, hot_[i].rate_per_us))
      events.push_back({hot.next_us, hot_[i].x, hot.random.chance(kHotOnShare)});
  }
}

}  // namespace egofocus::citysim
