#include <algorithm>
#include <stdexcept>
#include <string>

#include "citysim/dvs.hpp"
#include "citysim/dvs_state.hpp"
#include "citysim/random.hpp"

namespace egofocus::citysim {
namespace {

struct Field {
  const char* name;
  double DvsParameters::*member;
  double least;
  double most;
};

constexpr Field kFields[] = {
    {"threshold_on", &DvsParameters::threshold_on, 0.01, 4},
    {"threshold_off", &DvsParameters::threshold_off, 0.01, 4},
    {"threshold_spread", &DvsParameters::threshold_spread, 0, 1},
    {"refractory_us", &DvsParameters::refractory_us, 0, 1e6},
    {"bandwidth_hz", &DvsParameters::bandwidth_hz, 0, 1e6},
    {"bandwidth_floor_hz", &DvsParameters::bandwidth_floor_hz, 0, 1e6},
    {"dark_light", &DvsParameters::dark_light, 0, 1},
    {"leak_hz", &DvsParameters::leak_hz, 0, 1e4},
    {"shot_noise_hz", &DvsParameters::shot_noise_hz, 0, 1e4},
    {"noise_spread", &DvsParameters::noise_spread, 0, 3},
    {"hot_pixel_share", &DvsParameters::hot_pixel_share, 0, 1},
    {"hot_pixel_hz", &DvsParameters::hot_pixel_hz, 0, 1e5},
    {"latency_us", &DvsParameters::latency_us, 0, 1e6},
    {"latency_jitter_us", &DvsParameters::latency_jitter_us, 0, 1e6},
    {"readout_events_per_s", &DvsParameters::readout_events_per_s, 0, 1e10},
    {"readout_queue_events", &DvsParameters::readout_queue_events, 0, 1e6},
};

}  // namespace

std::vector<NamedValue> describe(const DvsParameters& parameters) {
  std::vector<NamedValue> values;
  for (const Field& field : kFields) values.push_back({field.name, parameters.*field.member});
  return values;
}

void require_legal(const DvsParameters& parameters) {
  for (const Field& field : kFields) {
    const double value = parameters.*field.member;
    if (!(value >= field.least && value <= field.most))
      throw std::invalid_argument(std::string("Dvs: ") + field.name + " is out of range.");
  }
  if (parameters.bandwidth_floor_hz > parameters.bandwidth_hz)
    throw std::invalid_argument("Dvs: bandwidth_floor_hz is above bandwidth_hz.");
  if (parameters.readout_events_per_s > 0 && parameters.readout_events_per_s < 1000)
    throw std::invalid_argument("Dvs: readout_events_per_s is out of range.");
}

DvsParameters draw_dvs_parameters(std::uint64_t seed, bool night) {
  const auto draw = [&](const char* what) { return sim::Random(seed, what); };
  DvsParameters p;
  // The middle of the range is what sensors are set to: near its upper end hardly an event is signal.
  sim::Random threshold = draw("threshold");
  p.threshold_on = threshold.log_uniform(0.1, 1.0);
  if (threshold.chance(0.5)) p.threshold_on = square_root(p.threshold_on * threshold.log_uniform(0.1, 1.0));
  // Simulators use N(1, 0.1), which hardly gives less than 46 % ON. Real excerpts have 36, 36, 42 and 57 %,
  // and where frames tell the contrast of a DAVIS240C's events, OFF is 0.5 to 0.8 of ON.
  p.threshold_off = p.threshold_on * std::clamp(0.9 + 0.2 * draw("ratio of thresholds").normal(), 0.5, 1.4);
  p.threshold_spread = draw("spread of thresholds").uniform(0.03, 0.08);
  // Half of them below 0.75 ms. A DAVIS240C at its usual biases has hardly an interval below 2.6 ms.
  const double refractory = draw("refractory period").uniform();
  p.refractory_us = 3000 * refractory * refractory;
  // A Gen3 sensor before something fast has most intervals of a pixel below 0.1 ms, which a corner of 300 Hz
  // does not give.
  p.bandwidth_hz = draw("bandwidth").log_uniform(100, night ? 200 : 3000);
  p.bandwidth_floor_hz = draw("bandwidth in the dark").log_uniform(30, night ? 45 : 60);
  p.dark_light = draw("dark light").log_uniform(0.0005, 0.005);
  p.leak_hz = draw("leak").uniform(0, 0.3);
  // Isolated events of real excerpts: 0.7 and 1.7, the latter with what the scene does to it.
  p.noise_spread = draw("spread of noise").uniform(0.3, 1.5);
  const double shot = draw("shot noise").uniform();
  // Most sensors are quiet, some are not.
  p.shot_noise_hz = (night ? 10.0 * shot * shot : 1.0) * shot * shot;
  p.hot_pixel_share = draw("hot pixels").uniform(0, 0.001);
  p.hot_pixel_hz = draw("rate of hot pixels").log_uniform(5, 200);
  p.latency_us = draw("latency").log_uniform(50, 500);
  p.latency_jitter_us = p.latency_us * draw("jitter").uniform(0.05, 0.3);
  p.readout_events_per_s = draw("read-out").log_uniform(2e6, 5e7);
  p.readout_queue_events = draw("queue").uniform(64, 1024);
  return p;
}

}  // namespace egofocus::citysim
