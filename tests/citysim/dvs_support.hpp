// Lights for the sensor's tests, and the sensor run over them.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "citysim/dvs.hpp"

namespace egofocus::citysim::test {

/// Linear light at a pixel and a time.
using Light = std::function<double(int x, int y, double t_us)>;

struct Run {
  std::vector<Event> events;
  DvsCounters counters;
};

inline std::vector<float> picture(int width_px, int height_px, const Light& light, std::int64_t t_us) {
  std::vector<float> view;
  for (int y = 0; y < height_px; ++y) {
    for (int x = 0; x < width_px; ++x)
      view.push_back(static_cast<float>(light(x, y, static_cast<double>(t_us))));
  }
  return view;
}

/// Shows views at `first_us`, `first_us` + `step_us`, ... until `last_us`, one a call.
inline Run run(int width_px, int height_px, const DvsParameters& parameters, std::uint64_t seed,
               const Light& light, std::int64_t first_us, std::int64_t step_us, std::int64_t last_us,
               int threads = 1) {
  Dvs dvs(width_px, height_px, parameters, seed);
  Workers workers(threads);
  Run result;
  for (std::int64_t t_us = first_us; t_us <= last_us; t_us += step_us) {
    const std::vector<float> view = picture(width_px, height_px, light, t_us);
    const LightView shown{t_us, view};
    dvs.show({&shown, 1}, workers, result.events);
  }
  dvs.finish(result.events);
  result.counters = dvs.counters();
  return result;
}

inline bool operator==(const Event& a, const Event& b) {
  return a.t_us == b.t_us && a.x == b.x && a.y == b.y && a.polarity == b.polarity;
}
inline bool same(const std::vector<Event>& a, const std::vector<Event>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!(a[i] == b[i])) return false;
  }
  return true;
}

inline bool in_order(const std::vector<Event>& events) {
  for (std::size_t i = 1; i < events.size(); ++i) {
    const Event& a = events[i - 1];
    const Event& b = events[i];
    if (a.t_us != b.t_us ? a.t_us > b.t_us : (a.y != b.y ? a.y > b.y : a.x > b.x)) return false;
  }
  return true;
}

/// A drifting pattern with every fault of the sensor switched on.
inline DvsParameters faulty() {
  DvsParameters p = draw_dvs_parameters(11, true);
  p.threshold_on = 0.1;
  p.threshold_off = 0.12;
  p.leak_hz = 5;
  p.shot_noise_hz = 20;
  p.hot_pixel_share = 0.01;
  p.hot_pixel_hz = 500;
  p.latency_us = 300;
  p.latency_jitter_us = 150;
  p.refractory_us = 50;
  p.readout_events_per_s = 2e5;
  p.readout_queue_events = 20;
  return p;
}
inline Light drifting() {
  return [](int x, int y, double t_us) {
    return 0.3 + 0.28 * std::sin(0.5 * (x - t_us * 2e-4) + 0.3 * y) + (x % 7 == 0 ? 0.3 : 0.0);
  };
}

}  // namespace egofocus::citysim::test
