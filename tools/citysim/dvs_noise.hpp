// Events without a cause: leak, shot noise, hot pixels. Each row has its own clock of exponential gaps, so
// the cost is that of the events, not of the pixels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "citysim/dvs.hpp"
#include "citysim/random.hpp"

namespace egofocus::citysim {

struct NoiseEvent {
  double t_us;
  std::uint32_t x;
  bool on;
};

/// Leak and shot noise are Poisson processes: a row has one, which is shared out to its pixels by their noise
/// factors. Noise leaves reference levels alone.
/// Hot pixels have Poisson processes of their own, kHotOnShare of their events are ON.
class DvsNoise {
 public:
  static constexpr double kHotOnShare = 0.8;

  DvsNoise(int width_px, int height_px, const DvsParameters& parameters, std::uint64_t seed);

  /// Before the first call of add_row().
  void start(double t_us);

  /// Appends the events of row `y` until `t_us`, leak and shot noise first, each in order of time; calls of
  /// one row rise in time. `light`: the row's light at `t_us`. Different rows may be worked on at once.
  void add_row(int y, double t_us, std::span<const float> light, std::vector<NoiseEvent>& events);

  [[nodiscard]] std::size_t hot_pixels() const { return hot_.size(); }

  // What changes from call to call, for the sensor's state.
  struct Clock {
    double next_us;
    sim::Random random;
  };
  std::vector<Clock> row_clocks;
  std::vector<Clock> hot_clocks;

 private:
  [[nodiscard]] double row_rate(std::size_t row) const;  // events per microsecond, in the dark
  struct HotPixel {
    std::uint32_t x;
    double rate_per_us;
  };

  double leak_per_us_;
  double shot_per_us_;
  std::vector<double> factor_sum_;  // of the row, up to and with the pixel; empty without leak and shot noise
  std::vector<HotPixel> hot_;
  std::vector<std::size_t> first_hot_;  // of each row, and the end
  std::uint32_t width_px_;
};

}  // namespace egofocus::citysim
