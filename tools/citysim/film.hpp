// Films a world: views close enough in time that nothing moves more than a pixel, and the events they make.
#pragma once

#include <cstdint>
#include <vector>

#include "citysim/optics.hpp"
#include "citysim/renderer.hpp"
#include "citysim/workers.hpp"
#include "citysim/world.hpp"

namespace egofocus::citysim {

struct FilmCounters {
  std::uint64_t views = 0;
  std::uint64_t wide_steps = 0;  ///< views whose 99th percentile of motion since the last one is above 1 px
};

class Film {
 public:
  /// `optics` are the world's camera's. The first view is at `start_us`. All must outlive the film.
  Film(const World& world, const Optics& optics, Workers& workers, std::uint64_t seed,
       std::int64_t start_us = 0);

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
  void show_batch(std::span<const std::int64_t> times, std::vector<Event>& events);
  /// 99th percentile of the image speed in the view at `t_us`, px/s.
  [[nodiscard]] double fast_speed_px_s(const View& view, std::int64_t t_us) const;

  const World& world_;
  Workers& workers_;
  const Optics& optics_;
  Renderer renderer_;
  Dvs sensor_;
  std::vector<View> views_;
  std::vector<RenderScratch> scratches_;
  View last_;
  std::int64_t start_us_;
  std::int64_t last_us_ = -1;
  FilmCounters counters_;
};

}  // namespace egofocus::citysim
