// What a Dvs holds between two views.
#pragma once

#include <cstdint>
#include <vector>

#include "citysim/dvs.hpp"
#include "citysim/dvs_noise.hpp"
#include "citysim/dvs_readout.hpp"
#include "citysim/pixel_crossings.hpp"
#include "citysim/random.hpp"

namespace egofocus::citysim {

/// An event as one number, so that order of time, row, column is that of numbers: microseconds since the
/// first view, pixel, polarity.
using EventKey = std::uint64_t;
inline constexpr int kPixelBits = 21;
inline constexpr int kTimeShift = kPixelBits + 1;

inline EventKey event_key(std::int64_t since_start_us, std::size_t pixel, bool on) {
  return static_cast<EventKey>(since_start_us) << kTimeShift | static_cast<EventKey>(pixel) << 1 |
         (on ? 1u : 0u);
}

/// Throws std::invalid_argument: a number that is none, or outside what the header says.
void require_legal(const DvsParameters& parameters);

struct Dvs::State {
  State(int width, int height, const DvsParameters& p, std::uint64_t seed);

  void begin(const LightView& view);
  /// One row from the view before, at `from_us` since the start, to `view`. Rows are independent.
  struct Band;
  void show_row(int y, std::int64_t from_us, const LightView& view, Band& band);
  /// Reads out what can no longer be overtaken: all that is stamped before `until_us` since the start.
  void release(std::int64_t until_us, std::vector<Event>& events);

  int width_px;
  int height_px;
  DvsParameters parameters;
  std::uint64_t fingerprint;  ///< of all four arguments
  bool filtered;

  // One element a pixel. Times are microseconds since the first view.
  std::vector<Level> log;
  std::vector<Level> level;  ///< empty when not filtered: it is the log light
  std::vector<Level> upper;
  std::vector<Level> lower;
  std::vector<Level> on;
  std::vector<Level> off;
  std::vector<double> blocked_until_us;
  std::vector<std::int64_t> last_stamp_us;

  std::vector<sim::Random> latency;  ///< of each row
  DvsNoise noise;
  DvsReadout readout;
  std::vector<EventKey> pending;  ///< not yet read out, sorted
  std::vector<EventKey> served;   ///< read out, sorted; an equal stamp may still come
  DvsCounters counters;
  bool has_view = false;
  bool settled = false;  ///< the first view meets pixels that have been watching
  sim::Random phases;    ///< where those stand
  std::int64_t start_us = 0;
  std::int64_t now_us = 0;

  /// An event of the row at work, before refractory period, latency and read-out.
  struct Raised {
    double t_us;
    std::uint32_t x;
    bool on;
    bool noise;
  };
  /// Rows of one task, and its scratch memory.
  struct Band {
    std::vector<EventKey> events;
    DvsCounters counters;
    std::vector<Level> log1;
    std::vector<Level> level1;
    std::vector<std::uint8_t> marked;
    std::vector<Crossing> crossings;
    std::vector<NoiseEvent> noise;
    std::vector<Raised> raised;
  };
  std::vector<Band> bands;

 private:
  void look_closer(std::size_t row, std::size_t x, std::int64_t from_us, float k, double span_us, Band& band);
  void send(int y, Band& band);
};

}  // namespace egofocus::citysim
