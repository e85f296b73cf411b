// Noise and read-out against their rates; threads, calls and saved states against each other.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <stdexcept>

#include "citysim/dvs.hpp"
#include "citysim/random.hpp"
#include "core/elementary.hpp"
#include "dvs_support.hpp"

using namespace egofocus;
using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

namespace {

Light constant(double light) {
  return [light](int, int, double) { return light; };
}

std::map<int, int> count_by_pixel(const std::vector<Event>& events) {
  std::map<int, int> counts;
  for (const Event& event : events) ++counts[event.y * 1000 + event.x];
  return counts;
}

}  // namespace

TEST_CASE("leak: ON events at its rate, Poisson over pixels and over time") {
  DvsParameters p;
  p.leak_hz = 3;
  const Run result = run(100, 50, p, 4, constant(0.5), 0, 10'000, 2'000'000);
  const double expected = 3 * 2 * 5000;
  REQUIRE(std::abs(static_cast<double>(result.events.size()) - expected) < 4 * std::sqrt(expected));
  REQUIRE(result.counters.noise_events == result.events.size());
  for (const Event& event : result.events) REQUIRE(event.polarity == 1);
  // Counts of a pixel: Poisson of mean 6, so chi-square over the pixels is their number +- 4 sigma.
  const std::map<int, int> counts = count_by_pixel(result.events);
  double chi = (5000.0 - static_cast<double>(counts.size())) * 6;
  for (const auto& [pixel, count] : counts) chi += (count - 6.0) * (count - 6.0) / 6;
  REQUIRE(std::abs(chi - 5000) < 4 * std::sqrt(2.0 * 5000 + 5000 / 6.0));
  // And the same in 100 slices of time.
  std::vector<int> slices(100, 0);
  for (const Event& event : result.events)
    ++slices[std::min<std::size_t>(99, static_cast<std::size_t>(event.t_us / 20'000))];
  double chi_time = 0;
  for (const int count : slices) chi_time += (count - 300.0) * (count - 300.0) / 300;
  REQUIRE(std::abs(chi_time - 100) < 4 * std::sqrt(200.0));
}

TEST_CASE("noise differs from pixel to pixel as much as asked for") {
  DvsParameters p;
  p.leak_hz = 100;
  p.noise_spread = 0.3;
  const Run result = run(40, 25, p, 4, constant(0.5), 0, 10'000, 2'000'000);
  const double mean = static_cast<double>(result.events.size()) / 1000;
  REQUIRE(mean == Approx(200).epsilon(0.04));
  double variance = 0;
  for (const auto& [pixel, count] : count_by_pixel(result.events))
    variance += (count - mean) * (count - mean) / 1000;
  // Of the log-normal spread and of the counting.
  REQUIRE(variance == Approx(200 * 200 * std::expm1(0.09) + 200).epsilon(0.15));
}

TEST_CASE("shot noise: both polarities, half the rate at its half light") {
  DvsParameters p;
  p.shot_noise_hz = 10;
  const auto half = static_cast<double>(kHalfShotLight);
  for (const double light : {0.0, half, 1.0}) {
    const Run result = run(100, 50, p, 4, constant(light), 0, 10'000, 1'000'000);
    const double expected = 10.0 * 5000 * half / (half + light);
    REQUIRE(std::abs(static_cast<double>(result.events.size()) - expected) < 4 * std::sqrt(expected));
    double on = 0;
    for (const Event& event : result.events) on += event.polarity;
    REQUIRE(std::abs(on - expected / 2) < 4 * std::sqrt(expected));
  }
}

TEST_CASE("hot pixels: their share, their mean rate, mostly ON, and nothing elsewhere") {
  DvsParameters p;
  p.hot_pixel_share = 0.02;
  p.hot_pixel_hz = 300;
  const Run result = run(200, 100, p, 9, constant(0.5), 0, 10'000, 2'000'000);
  const std::map<int, int> counts = count_by_pixel(result.events);
  REQUIRE(std::abs(static_cast<double>(counts.size()) - 400) < 4 * 20);
  const double mean = static_cast<double>(result.events.size()) / static_cast<double>(counts.size()) / 2;
  REQUIRE(mean == Approx(300).epsilon(4 / 20.0));  // exponential rates: 1 sigma is 1 / sqrt(400)
  double on = 0;
  for (const Event& event : result.events) on += event.polarity;
  REQUIRE(on / static_cast<double>(result.events.size()) == Approx(0.8).epsilon(0.01));
}

TEST_CASE("noise leaves the signal alone, and waits for the refractory period, too") {
  DvsParameters p;
  const Run quiet = run(30, 20, p, 2, drifting(), 0, 1000, 100'000);
  p.leak_hz = 50;
  const Run noisy = run(30, 20, p, 2, drifting(), 0, 1000, 100'000);
  REQUIRE(noisy.counters.signal_events == quiet.events.size());
  REQUIRE(noisy.events.size() == quiet.events.size() + noisy.counters.noise_events);
  REQUIRE(noisy.counters.noise_events > 2000);

  p = {};
  p.leak_hz = 1000;
  p.refractory_us = 5000;
  const Run held = run(10, 10, p, 2, constant(1), 0, 1000, 1'000'000);
  std::map<int, std::int64_t> last;
  for (const Event& event : held.events) {
    const auto [at, is_first] = last.try_emplace(event.y * 10 + event.x, event.t_us);
    if (!is_first) REQUIRE(event.t_us - at->second >= 4999);
    at->second = event.t_us;
  }
  // A dead time of 5 ms after each event of a 1 kHz process: 1 / 6 ms.
  REQUIRE(static_cast<double>(held.events.size()) == Approx(100 / 0.006).epsilon(0.03));
  REQUIRE(static_cast<double>(held.counters.refractory_dropped) == Approx(100 * 5 / 0.006).epsilon(0.03));
}

TEST_CASE("read-out: no more than its rate comes out, late ones wait, the rest is counted") {
  DvsParameters p;
  p.readout_events_per_s = 100'000;  // 10 us each
  p.readout_queue_events = 30;
  // All 400 pixels cross at 1,000 us, and again at 3,000 us.
  const Light steps = [](int, int, double t_us) {
    return std::exp(0.26 * std::floor(t_us / 1000 / 2 + 0.5));
  };
  const Run result = run(20, 20, p, 1, steps, 0, 1, 10'000);
  REQUIRE(result.counters.signal_events == 5 * 400);
  REQUIRE(result.events.size() + result.counters.readout_dropped == 5 * 400);
  REQUIRE(result.events.size() == 5 * 31);  // one is served at once, 30 wait
  REQUIRE(in_order(result.events));
  for (std::size_t i = 0; i < result.events.size(); ++i) {
    const auto burst = static_cast<std::int64_t>(i / 31);
    const std::int64_t late =
        result.events[i].t_us - (999 + 2000 * burst) - static_cast<std::int64_t>(i % 31) * 10;
    REQUIRE((late == 0 || late == 1));
  }

  // Several a microsecond: those that asked at different times and are stamped together are in order, too.
  p.readout_events_per_s = 3e6;
  p.readout_queue_events = 1000;
  p.latency_us = 100;
  p.latency_jitter_us = 20;
  const Run crowded = run(20, 20, p, 1, steps, 0, 1, 10'000);
  REQUIRE(crowded.events.size() == 5 * 400);
  REQUIRE(in_order(crowded.events));

  const DvsParameters rough = faulty();
  const Run busy = run(40, 30, rough, 3, drifting(), 0, 1000, 300'000);
  REQUIRE(busy.counters.readout_dropped > 100);
  REQUIRE(busy.counters.noise_events > 100);
  REQUIRE(busy.counters.signal_events + busy.counters.noise_events ==
          busy.events.size() + busy.counters.readout_dropped);
  REQUIRE(in_order(busy.events));
  for (std::size_t i = 1; i < busy.events.size(); ++i)  // 5 us each
    if (i >= 20) REQUIRE(busy.events[i].t_us - busy.events[i - 20].t_us >= 99);
}

TEST_CASE("the same events for any number of threads and any cut into calls") {
  const DvsParameters p = faulty();
  const Run one = run(50, 37, p, 3, drifting(), 77, 1000, 120'000);
  REQUIRE(one.events.size() > 5000);
  for (const int threads : {2, 5}) {
    const Run more = run(50, 37, p, 3, drifting(), 77, 1000, 120'000, threads);
    REQUIRE(same(one.events, more.events));
  }
  REQUIRE_FALSE(same(one.events, run(50, 37, p, 4, drifting(), 77, 1000, 120'000).events));

  std::vector<std::vector<float>> pictures;
  std::vector<LightView> views;
  for (std::int64_t t_us = 77; t_us <= 120'000; t_us += 1000)
    pictures.push_back(picture(50, 37, drifting(), t_us));
  for (std::size_t i = 0; i < pictures.size(); ++i)
    views.push_back({77 + 1000 * static_cast<std::int64_t>(i), pictures[i]});
  for (const std::size_t at_once : {std::size_t{7}, views.size()}) {
    Dvs dvs(50, 37, p, 3);
    Workers workers(2);
    std::vector<Event> events;
    for (std::size_t i = 0; i < views.size(); i += at_once)
      dvs.show(std::span(views).subspan(i, std::min(at_once, views.size() - i)), workers, events);
    dvs.finish(events);
    REQUIRE(same(one.events, events));
  }
}

TEST_CASE("the same events from every compiler") {
  // Light from exact operations alone, so that the hash is the sensor's.
  const Light light = [](int x, int y, double t_us) {
    const double wave = sine(0.5 * (x - t_us * 2e-4) + 0.3 * y);
    return 0.3 + 0.28 * wave + (x % 7 == 0 ? 0.3 : 0.0);
  };
  DvsParameters p = draw_dvs_parameters(6, true);
  p.readout_events_per_s = 3e5;
  p.hot_pixel_share = 0.01;
  const Run result = run(50, 37, p, 3, light, 5, 1000, 100'000);
  std::uint64_t hash = 0;
  for (const Event& event : result.events) {
    hash = sim::mix_bits(hash ^ static_cast<std::uint64_t>(event.t_us));
    hash = sim::mix_bits(hash ^ (event.x * 65536u + event.y * 2u + event.polarity));
  }
  CHECK(result.events.size() == 29638);
  CHECK(hash == 0x51d41c1f528ff7ba);
}

TEST_CASE("a saved state goes on with the same events, wherever it was taken") {
  std::vector<std::vector<float>> pictures;
  for (int i = 0; i < 60; ++i) pictures.push_back(picture(50, 37, drifting(), 1000 * i));
  Workers workers(2);
  const auto show = [&](Dvs& dvs, std::size_t i, std::vector<Event>& events) {
    const LightView shown{1000 * static_cast<std::int64_t>(i), pictures[i]};
    dvs.show({&shown, 1}, workers, events);
  };
  for (const double readout : {2e5, 0.0}) {
    DvsParameters p = faulty();
    p.readout_events_per_s = readout;
    Dvs first(50, 37, p, 3);
    std::vector<Event> whole;
    struct Saved {
      std::vector<std::uint8_t> state;
      std::size_t events;
    };
    std::vector<Saved> saved;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      saved.push_back({first.state(), whole.size()});
      show(first, i, whole);
    }
    first.finish(whole);
    for (std::size_t from = 0; from < pictures.size(); from += 4) {
      Dvs second(50, 37, p, 3);
      second.restore(saved[from].state);
      REQUIRE(second.state() == saved[from].state);
      std::vector<Event> events(whole.begin(),
                                whole.begin() + static_cast<std::ptrdiff_t>(saved[from].events));
      for (std::size_t i = from; i < pictures.size(); ++i) show(second, i, events);
      second.finish(events);
      REQUIRE(same(whole, events));
      REQUIRE(second.counters().signal_events == first.counters().signal_events);
      REQUIRE(second.counters().noise_events == first.counters().noise_events);
      REQUIRE(second.counters().refractory_dropped == first.counters().refractory_dropped);
      REQUIRE(second.counters().readout_dropped == first.counters().readout_dropped);
    }
  }
}

TEST_CASE("what is no state of this sensor is refused and changes nothing") {
  const DvsParameters p = faulty();
  Workers workers(1);
  Dvs dvs(50, 37, p, 3);
  std::vector<Event> events;
  for (int i = 0; i < 5; ++i) {
    const std::vector<float> view = picture(50, 37, drifting(), 1000 * i);
    const LightView shown{1000 * i, view};
    dvs.show({&shown, 1}, workers, events);
  }
  const std::vector<std::uint8_t> saved = dvs.state();
  for (std::size_t i = 0; i < saved.size(); i += 997) {
    std::vector<std::uint8_t> damaged = saved;
    damaged[i] ^= 0x10;
    REQUIRE_THROWS_AS(dvs.restore(damaged), std::invalid_argument);
    REQUIRE_THROWS_AS(dvs.restore(std::span(saved).first(i)), std::invalid_argument);
  }
  REQUIRE(dvs.state() == saved);
  Dvs other_seed(50, 37, p, 4);
  REQUIRE_THROWS_AS(other_seed.restore(saved), std::invalid_argument);
  Dvs other_size(37, 50, p, 3);
  REQUIRE_THROWS_AS(other_size.restore(saved), std::invalid_argument);
  DvsParameters changed = p;
  changed.leak_hz += 0.1;
  Dvs other_parameters(50, 37, changed, 3);
  REQUIRE_THROWS_AS(other_parameters.restore(saved), std::invalid_argument);
}
