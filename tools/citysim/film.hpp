// Films a world: views close enough in time that nothing moves more than a pixel, and the events they make.
//
// Each tile of the picture is rendered as often as what is seen in it asks for: at every step of a batch, or
// at every second, fourth or eighth. In between its light is linear in time. Lamps flicker faster than that:
// their part of the light follows the mains.
#pragma once

#include <cstdint>
#include <vector>

#include "citysim/film_pace.hpp"
#include "citysim/optics.hpp"
#include "citysim/renderer.hpp"
#include "citysim/workers.hpp"
#include "citysim/world.hpp"

namespace egofocus::citysim {

struct FilmCounters {
  std::uint64_t views = 0;
  std::uint64_t wide_steps = 0;  ///< views whose 99th percentile of motion since the last one is above 1 px
  std::uint64_t tiles = 0;       ///< rendered
};

class Film {
 public:
  /// `optics` are the world's camera's. The first view is at `start_us`. All must outlive the film.
  Film(const World& world, const Optics& optics, Workers& workers, std::uint64_t seed,
       std::int64_t start_us = 0);

  /// A new take with the same sensor, from `start_us`, as if the sensor had been watching for long: each
  /// pixel stands somewhere between its thresholds. What waits in it is lost. Counters go on.
  void cut_to(std::int64_t start_us);

  /// Goes on to `t_us`, which is a view itself; appends the events on the way. Events whose stamps may still
  /// be overtaken come with the next call.
  void run_to(std::int64_t t_us, std::vector<Event>& events);
  /// What still waits in the sensor, at the end.
  void finish(std::vector<Event>& events) { sensor_.finish(events); }

  [[nodiscard]] const FilmCounters& counters() const { return counters_; }
  [[nodiscard]] const DvsCounters& sensor_counters() const { return sensor_.counters(); }

  /// To go on later, from the time of the last run_to(). restore() throws std::invalid_argument.
  [[nodiscard]] std::vector<std::uint8_t> state() const;
  void restore(std::span<const std::uint8_t> state);

 private:
  static constexpr int kSteps = 8;  // of a batch

  /// times_us[0] is that of the view before, views_[0].
  struct Batch {
    int steps = 0;
    std::int64_t times_us[kSteps + 1];
    std::vector<int> stride;  ///< of each tile: it is rendered at multiples of it, and at the last step
  };
  /// What the sensor is shown.
  struct Exposure {
    std::int64_t t_us;
    int step;  ///< the first at or after it
    std::vector<std::uint8_t> bands;
    std::vector<float> light;
    std::vector<float> spare;
  };

  void look(std::int64_t t_us);
  void begin(std::vector<Event>& events);
  [[nodiscard]] Batch plan(std::int64_t t_us) const;
  void render(const Batch& batch);
  void expose(const Batch& batch, Exposure& exposure) const;
  void show(const Batch& batch, std::vector<Event>& events);
  void count(const Batch& batch);

  const World& world_;
  Workers& workers_;
  const Optics& optics_;
  Renderer renderer_;
  Dvs sensor_;
  std::vector<View> views_;  ///< without lens blur; [0] is the last one, whole
  FilmPace pace_;            ///< at views_[0]
  std::vector<RenderScratch> scratches_;
  std::vector<Exposure> exposures_;
  std::int64_t start_us_;
  std::int64_t last_us_ = -1;
  FilmCounters counters_;
};

}  // namespace egofocus::citysim
