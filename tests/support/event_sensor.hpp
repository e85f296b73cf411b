// A pixel array that turns log intensity into events: per-pixel thresholds, reference levels carried exactly
// from view to view, time stamps linear between two views, some noise.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "citysim/random.hpp"
#include "egofocus/config.hpp"

namespace egofocus::sim {

struct SensorFaults {
  double threshold = 0.34;         ///< in log intensity
  double threshold_spread = 0.03;  ///< 1-sigma over the pixels, relative; ON and OFF apart
  double noise_hz = 0.02;          ///< events per pixel and second without cause
  std::int64_t readout_us = 250;  ///< time stamps are multiples of it, rounded down; views come at such times
};

/// Normalised direction of a pixel.
struct Ray {
  double x = 0;
  double y = 0;
};

/// Ray of each raw pixel, row-major: the distortion is inverted by fixed-point iteration to 1e-12. kNone and
/// kPlumbBob only.
std::vector<Ray> pixel_rays(const CameraModel& camera);

class EventSensor {
 public:
  EventSensor(const Intrinsics& size, const SensorFaults& faults, std::uint64_t seed);

  /// Shows the view (log intensity, row-major) at `t_us`; appends the events since the last view, sorted by
  /// time, row and column. The first view sets the reference levels; times must rise.
  void show(std::int64_t t_us, std::span<const double> view, std::vector<Event>& events);

 private:
  struct Pixel {
    double on_threshold = 0;
    double off_threshold = 0;
    double reference = 0;
    double last = 0;
  };
  void change(std::size_t index, std::int64_t t_us, double level, std::vector<Event>& events);
  void add_noise(std::int64_t t_us, std::vector<Event>& events);
  [[nodiscard]] Event event_at(std::size_t index, std::int64_t t_us, bool on) const;

  std::uint32_t width_px_;
  SensorFaults faults_;
  Random random_;
  std::vector<Pixel> pixels_;
  std::int64_t last_us_ = 0;
  double noise_owed_ = 0;
  bool has_view_ = false;
};

}  // namespace egofocus::sim
