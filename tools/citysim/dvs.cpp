#include "citysim/dvs.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "citysim/dvs_state.hpp"

namespace egofocus::citysim {
namespace {

// 12 days. With latency and wait, a stamp stays below 2^41.
constexpr std::int64_t kLongest_us = std::int64_t{1} << 40;

}  // namespace

Dvs::Dvs(int width_px, int height_px, const DvsParameters& parameters, std::uint64_t seed) {
  if (width_px < 1 || height_px < 1 || width_px > 65535 || height_px > 65535 ||
      static_cast<std::int64_t>(width_px) * height_px > std::int64_t{1} << kPixelBits)
    throw std::invalid_argument("Dvs: a size between 1 x 1 and 2^21 pixels is needed.");
  require_legal(parameters);
  state_ = std::make_unique<State>(width_px, height_px, parameters, seed);
}

Dvs::~Dvs() = default;

const DvsCounters& Dvs::counters() const {
  return state_->counters;
}

void Dvs::show(std::span<const LightView> views, Workers& workers, std::vector<Event>& events) {
  State& s = *state_;
  const std::size_t pixels = s.upper.size();
  const int bands = (s.height_px + kBandRows - 1) / kBandRows;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].light.size() != pixels) throw std::invalid_argument("Dvs: a view of the wrong size.");
    if (!views[i].bands.empty() && views[i].bands.size() != static_cast<std::size_t>(bands))
      throw std::invalid_argument("Dvs: a view with the wrong number of bands.");
    if (i == 0 && !s.has_view) continue;
    const std::int64_t before_us = i > 0 ? views[i - 1].t_us : s.now_us;
    const std::int64_t start_us = s.has_view ? s.start_us : views[0].t_us;
    if (views[i].t_us <= before_us) throw std::invalid_argument("Dvs: the times of views must rise.");
    if (static_cast<std::uint64_t>(views[i].t_us) - static_cast<std::uint64_t>(start_us) >=
        static_cast<std::uint64_t>(kLongest_us))
      throw std::invalid_argument("Dvs: a view later than 12 days after the first.");
  }
  if (!views.empty() && !s.has_view) {
    s.begin(views.front());
    views = views.subspan(1);
  }
  if (views.empty()) return;

  s.bands.resize(static_cast<std::size_t>(bands));
  workers.for_each(bands, [&](int i) {
    State::Band& band = s.bands[static_cast<std::size_t>(i)];
    std::int64_t from_us = s.now_us - s.start_us;
    for (const LightView& view : views) {
      const bool looks = view.bands.empty() || view.bands[static_cast<std::size_t>(i)] != 0;
      if (!looks && &view != &views.back()) continue;
      for (int y = i * kBandRows; y < std::min((i + 1) * kBandRows, s.height_px); ++y)
        s.show_row(y, from_us, view, band);
      from_us = view.t_us - s.start_us;
    }
  });
  s.now_us = views.back().t_us;
  for (State::Band& band : s.bands) {
    s.pending.insert(s.pending.end(), band.events.begin(), band.events.end());
    band.events.clear();
    s.counters.signal_events += band.counters.signal_events;
    s.counters.noise_events += band.counters.noise_events;
    s.counters.refractory_dropped += band.counters.refractory_dropped;
    band.counters = {};
  }
  std::sort(s.pending.begin(), s.pending.end());
  s.release(s.now_us - s.start_us, events);
}

void Dvs::begin_take() {
  State& s = *state_;
  s.has_view = false;
  s.settled = true;
  s.pending.clear();
  s.served.clear();
  s.readout = DvsReadout(s.parameters.readout_events_per_s, s.parameters.readout_queue_events);
  std::fill(s.blocked_until_us.begin(), s.blocked_until_us.end(), std::numeric_limits<double>::lowest());
  std::fill(s.last_stamp_us.begin(), s.last_stamp_us.end(), 0);
}

void Dvs::finish(std::vector<Event>& events) {
  state_->release(std::numeric_limits<std::int64_t>::max() >> kTimeShift, events);
}

void Dvs::State::release(std::int64_t until_us, std::vector<Event>& events) {
  const EventKey until = event_key(until_us, 0, false);
  const auto done = std::lower_bound(pending.begin(), pending.end(), until);
  for (auto key = pending.begin(); key != done; ++key) {
    const auto asked_us = static_cast<std::int64_t>(*key >> kTimeShift);
    if (const auto stamp_us = readout.accept(asked_us)) {
      served.push_back(*key + (static_cast<EventKey>(*stamp_us - asked_us) << kTimeShift));
    } else {
      ++counters.readout_dropped;
    }
  }
  pending.erase(pending.begin(), done);

  // Stamps never fall, but those that waited into one microsecond are in the order of their requests.
  if (parameters.readout_events_per_s > 0) std::sort(served.begin(), served.end());
  const auto out = std::lower_bound(served.begin(), served.end(), until);
  for (auto key = served.begin(); key != out; ++key) {
    const auto pixel = static_cast<std::uint32_t>(*key >> 1) & ((1u << kPixelBits) - 1);
    const auto width = static_cast<std::uint32_t>(width_px);
    Event event;
    event.t_us = start_us + static_cast<std::int64_t>(*key >> kTimeShift);
    event.x = static_cast<std::uint16_t>(pixel % width);
    event.y = static_cast<std::uint16_t>(pixel / width);
    event.polarity = *key & 1;
    events.push_back(event);
  }
  served.erase(served.begin(), out);
}

}  // namespace egofocus::citysim
