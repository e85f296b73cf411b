// An event camera's pixel array: linear light in, events out, with the faults of real sensors.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "citysim/workers.hpp"
#include "egofocus/types.hpp"

namespace egofocus::citysim {

/// One recording's sensor. The defaults are a clean one: no fault at all. 1-sigma spreads are over the
/// pixels.
struct DvsParameters {
  double threshold_on = 0.25;  ///< contrast, in natural log intensity; 0.01 to 4
  double threshold_off = 0.25;
  double threshold_spread = 0;    ///< relative; ON and OFF apart
  double refractory_us = 0;       ///< after an event of a pixel its crossings and its noise are lost
  double bandwidth_hz = 0;        ///< first-order low pass of log light, of a pixel at intensity 1; 0: none
  double bandwidth_floor_hz = 0;  ///< in the dark; the corner is linear in the light, so above 1 it goes on
  double dark_light = 0;          ///< added to the light before the logarithm (dark current)
  double leak_hz = 0;             ///< ON events per pixel and second without cause
  double shot_noise_hz =
      0;                    ///< of both polarities, per pixel and second, in the dark; half at kHalfShotLight
  double noise_spread = 0;  ///< of the natural log of a pixel's leak and shot noise; the mean stays
  double hot_pixel_share = 0;
  double hot_pixel_hz = 0;            ///< mean rate of a hot pixel; the rates are distributed exponentially
  double latency_us = 0;              ///< from the crossing to the stamp; noise is stamped at once
  double latency_jitter_us = 0;       ///< 1-sigma; stamps never run before the crossing
  double readout_events_per_s = 0;    ///< more wait in the array and are stamped late, then lost; 0: no limit
  double readout_queue_events = 256;  ///< that may wait
};

/// Where shot noise has half its rate of the dark: rate = shot_noise_hz * half / (half + light).
inline constexpr float kHalfShotLight = 0.05f;

/// Drawn per recording. `night` has more shot noise and less bandwidth; all else is the same for one seed.
///
///   threshold_on          0.1 to 1, as published simulators randomise; log-uniform, half of them drawn to
///   the middle threshold_off         N(0.9, 0.2) of threshold_on, 0.5 to 1.4 threshold_spread      0.03 to
///   0.08: sigma/C of published DVS pixels refractory_us         0 to 3,000, half of them below 750
///   bandwidth_hz          100 to 3,000 (night: 200), log-uniform; in the dark 30 to 60 (night: 45)
///   dark_light            0.0005 to 0.005, log-uniform
///   leak_hz               0 to 0.3
///   shot_noise_hz         0 to 1 (night: 10), half of them below a quarter (night: a sixteenth) of that
///   noise_spread          0.3 to 1.5
///   hot_pixel_share       0 to 0.001, at 5 to 200 Hz
///   latency_us            50 to 500, log-uniform; its jitter 0.05 to 0.3 of it
///   readout_events_per_s  2e6 to 5e7, log-uniform; 64 to 1,024 wait
///
/// `citysim realism` compares them with real excerpts; over a scrolling texture their statistics take in
/// those of a DAVIS240C beside a slider (a test).
[[nodiscard]] DvsParameters draw_dvs_parameters(std::uint64_t seed, bool night);

struct NamedValue {
  std::string_view name;
  double value = 0;
};
/// Every parameter under the name of its member, in their order: for a recording's metadata.
[[nodiscard]] std::vector<NamedValue> describe(const DvsParameters& parameters);

/// Each event that passes the refractory period is in `signal_events` or `noise_events`; their sum is what
/// came out, what still waits, and `readout_dropped`.
struct DvsCounters {
  std::uint64_t signal_events = 0;       ///< from contrast
  std::uint64_t noise_events = 0;        ///< leak, shot noise, hot pixels
  std::uint64_t refractory_dropped = 0;  ///< of both kinds
  std::uint64_t readout_dropped = 0;
};

/// The scene's light at one time, linear, row-major; 1 is a white wall by day, 0.001 a dark corner by night.
struct LightView {
  std::int64_t t_us = 0;
  std::span<const float> light;
  /// Of each Dvs::kBandRows rows: do they look? To the others this view is one that light goes through on its
  /// straight way. All look when empty, and at the last view of a call.
  std::span<const std::uint8_t> bands{};
};

class Dvs {
 public:
  static constexpr int kBandRows = 8;

  /// At most 2^21 pixels. Throws std::invalid_argument when the size or a parameter is out of range.
  Dvs(int width_px, int height_px, const DvsParameters& parameters, std::uint64_t seed);
  ~Dvs();

  /// The next views, rising in time (by at most 12 days in all), the first ever sets the reference levels.
  /// Log light is taken as linear between two views; below 1e-6 and above 1e6 it counts as that bound.
  /// Levels are integers of 2^-24, so references are carried exactly; a stamp is the microsecond in which
  /// its crossing lies, plus latency. Appends events in order of time, row, column; an event whose stamp may
  /// still be overtaken waits for a later call. Same bytes for any number of workers, and however the views
  /// are cut into calls. Throws std::invalid_argument, before anything is done, on times that do not rise or
  /// a view of the wrong size.
  void show(std::span<const LightView> views, Workers& workers, std::vector<Event>& events);
  /// The next view is a first one again, at any time, of the same pixels. As if they had been watching for
  /// long before: each stands somewhere between its thresholds. What waits is lost.
  void begin_take();
  /// What still waits, at the end.
  void finish(std::vector<Event>& events);

  [[nodiscard]] const DvsCounters& counters() const;

  /// The whole state, to go on later: a Dvs made with the same arguments and this state goes on with the same
  /// bytes. restore() throws std::invalid_argument when the bytes are not such a state.
  [[nodiscard]] std::vector<std::uint8_t> state() const;
  void restore(std::span<const std::uint8_t> state);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace egofocus::citysim
