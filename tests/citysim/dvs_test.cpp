// The sensor against what its model says in closed form.
#include "citysim/dvs.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "dvs_support.hpp"

using namespace egofocus;
using namespace egofocus::citysim;
using namespace egofocus::citysim::test;

namespace {

std::vector<Event> of_pixel(const std::vector<Event>& events, int x, int y) {
  std::vector<Event> own;
  for (const Event& event : events) {
    if (event.x == x && event.y == y) own.push_back(event);
  }
  return own;
}

}  // namespace

TEST_CASE("a clean sensor on an exponential ramp: each crossing at its microsecond") {
  DvsParameters p;
  p.threshold_on = 0.3;
  p.threshold_off = 0.2;
  // ln light = slope t: the log light is straight between views, so no sampling error is left.
  for (const double slope_per_s : {7.3, 0.9, -7.3, -0.9}) {
    const Light ramp = [&](int, int, double t_us) { return std::exp(slope_per_s * t_us * 1e-6); };
    const Run result = run(3, 2, p, 1, ramp, 0, 1000, 500'000);
    const double threshold = slope_per_s > 0 ? 0.3 : 0.2;
    const auto expected = static_cast<std::size_t>(std::abs(slope_per_s) * 0.5 / threshold);
    for (int x = 0; x < 3; ++x) {
      const std::vector<Event> own = of_pixel(result.events, x, 1);
      REQUIRE(own.size() == expected);
      for (std::size_t i = 0; i < own.size(); ++i) {
        const double at_us = static_cast<double>(i + 1) * threshold / std::abs(slope_per_s) * 1e6;
        REQUIRE(std::abs(static_cast<double>(own[i].t_us) - std::floor(at_us)) <= 1.0);
        REQUIRE(own[i].polarity == (slope_per_s > 0 ? 1 : 0));
      }
    }
    REQUIRE(result.counters.signal_events == 6 * expected);
    REQUIRE(result.counters.noise_events + result.counters.readout_dropped == 0);
  }
}

TEST_CASE("references are carried exactly: up and down for long, and no event is lost or made up") {
  DvsParameters p;
  p.threshold_on = p.threshold_off = 0.13;
  // A triangle of log light between 0 and 10.001 thresholds: ten ON up, ten OFF down to 0 is the first of
  // them short by nothing: the reference at the top is 10, the one at the bottom 0.
  const double top = 10.001 * 0.13;
  const Light triangle = [&](int, int, double t_us) {
    const double phase = std::fmod(t_us / 20'000.0, 2.0);
    return std::exp(top * (phase <= 1 ? phase : 2 - phase) - (phase > 1 ? 1e-6 : 0) * 0.13);
  };
  const Run result = run(2, 1, p, 1, triangle, 0, 2000, 40'000 * 200);
  const std::vector<Event> own = of_pixel(result.events, 0, 0);
  int reference = 0;
  int lowest = 0;
  int highest = 0;
  for (const Event& event : own) {
    reference += event.polarity ? 1 : -1;
    lowest = std::min(lowest, reference);
    highest = std::max(highest, reference);
  }
  REQUIRE(lowest == 0);
  REQUIRE(highest == 10);
  REQUIRE(own.size() >= 200 * 18);
  REQUIRE(own.size() <= 200 * 20);
}

TEST_CASE(
    "a moving edge: every pixel fires floor(contrast / threshold) events of one polarity as it passes") {
  // A blurred edge (linear in log light over 2 px), 0.5 px a view: contrast 1.5, threshold 0.25.
  const Light edge = [](int x, int, double t_us) {
    const double front_px = t_us * 1e-6 * 400 - 5.0;
    return 0.1 * std::exp(1.51 * std::clamp((front_px - x) / 2.0, 0.0, 1.0));
  };
  DvsParameters p;
  const Run result = run(40, 3, p, 1, edge, 0, 1250, 150'000);
  REQUIRE(result.events.size() == 40 * 3 * 6);
  REQUIRE(in_order(result.events));
  for (int x = 0; x < 40; ++x) {
    const std::vector<Event> own = of_pixel(result.events, x, 2);
    REQUIRE(own.size() == 6);
    for (std::size_t i = 0; i < 6; ++i) {
      REQUIRE(own[i].polarity == 1);
      const double at_us = (x + 5.0 + 2.0 * 0.25 * static_cast<double>(i + 1) / 1.51) / 400 * 1e6;
      // The corners of the edge may fall inside a view: half a view of error.
      REQUIRE(std::abs(static_cast<double>(own[i].t_us) - at_us) <= 625);
    }
  }
}

TEST_CASE("thresholds have the spread that was asked for, ON and OFF apart") {
  DvsParameters p;
  p.threshold_on = 0.4;
  p.threshold_off = 0.3;
  p.threshold_spread = 0.06;
  for (const bool on : {true, false}) {
    const double rise_per_us = on ? 1e-5 : -1e-5;
    const Light ramp = [&](int, int, double t_us) { return std::exp(rise_per_us * t_us); };
    const Run result = run(64, 64, p, 5, ramp, 0, 1000, 60'000);
    std::map<int, double> first;  // pixel -> threshold
    for (const Event& event : result.events)
      first.emplace(event.y * 64 + event.x, static_cast<double>(event.t_us) * 1e-5);
    REQUIRE(first.size() == 4096);
    double mean = 0;
    double square = 0;
    for (const auto& [pixel, threshold] : first) mean += threshold / 4096;
    for (const auto& [pixel, threshold] : first) square += (threshold - mean) * (threshold - mean) / 4096;
    const double nominal = on ? 0.4 : 0.3;
    REQUIRE(mean == Approx(nominal).epsilon(0.004));  // 4 sigma
    REQUIRE(std::sqrt(square) / nominal == Approx(0.06).epsilon(0.045));
  }
}

TEST_CASE("the refractory period loses what comes too soon, and counts it") {
  DvsParameters p;
  const Light ramp = [](int, int, double t_us) { return std::exp(1e-3 * t_us); };  // a crossing each 250 us
  const Run free = run(2, 2, p, 1, ramp, 0, 500, 10'000);
  p.refractory_us = 600;
  const Run held = run(2, 2, p, 1, ramp, 0, 500, 10'000);
  REQUIRE(held.events.size() + held.counters.refractory_dropped == free.events.size());
  const std::vector<Event> own = of_pixel(held.events, 1, 1);
  REQUIRE(own.size() == 14);  // of 40, the first and then each third
  for (std::size_t i = 1; i < own.size(); ++i) REQUIRE(std::abs(own[i].t_us - own[i - 1].t_us - 750) <= 1);
}

TEST_CASE("a low pass delays a step by what the closed form says, less in brighter light") {
  DvsParameters p;
  p.threshold_on = 0.5;
  p.bandwidth_hz = 200;
  p.bandwidth_floor_hz = 20;
  for (const double base : {0.01, 0.3, 1.0}) {
    const double lit = std::exp(0.9) * base;
    // From base to e^0.9 base within one view of 10 us, then constant.
    const Light step = [&](int, int, double t_us) { return t_us < 5 ? base : lit; };
    const Run result = run(1, 1, p, 1, step, 0, 10, 30'000);
    const double corner_hz = 20 + 180 * lit;
    const double tau_us = 1e6 / (2 * 3.14159265358979 * corner_hz);
    REQUIRE(result.events.size() == 1);
    // 0.9 (1 - e^(-t / tau)) = 0.5; the step's own 10 us are centred at 5 us.
    REQUIRE(static_cast<double>(result.events[0].t_us) == Approx(5 + tau_us * std::log(0.9 / 0.4)).margin(2));
  }
}

TEST_CASE("coarse views give the filtered crossings of fine ones") {
  DvsParameters p;
  p.bandwidth_hz = 100;
  p.bandwidth_floor_hz = 99.999;  // the same corner in any light, so that only the views differ
  // Straight log light between corners at multiples of 6 ms: coarse views see all of it.
  const Light zigzag = [](int x, int, double t_us) {
    const double phase = std::fmod(t_us / 6000.0 + 2.0 * (x % 2), 4.0);
    return std::exp(1.3 * (phase < 2 ? phase : 4 - phase));
  };
  const Run fine = run(4, 1, p, 1, zigzag, 0, 100, 240'000);
  const Run coarse = run(4, 1, p, 1, zigzag, 0, 6000, 240'000);
  REQUIRE(fine.events.size() > 400);
  REQUIRE(coarse.events.size() == fine.events.size());
  for (std::size_t x = 0; x < 4; ++x) {
    const std::vector<Event> a = of_pixel(fine.events, static_cast<int>(x), 0);
    const std::vector<Event> b = of_pixel(coarse.events, static_cast<int>(x), 0);
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      REQUIRE(std::abs(a[i].t_us - b[i].t_us) <= 2);
      REQUIRE(a[i].polarity == b[i].polarity);
    }
  }
}

TEST_CASE("dark current flattens contrast in the dark") {
  DvsParameters p;
  const Light step = [](int, int, double t_us) { return t_us < 1000 ? 0.001 : 0.01; };
  REQUIRE(run(1, 1, p, 1, step, 0, 1000, 5000).events.size() == 9);  // ln 10 / 0.25
  p.dark_light = 0.01;
  REQUIRE(run(1, 1, p, 1, step, 0, 1000, 5000).events.size() == 2);  // ln (0.02 / 0.011) / 0.25
}

TEST_CASE("latency is added, jitter never stamps before the crossing, a pixel's events keep their order") {
  DvsParameters p;
  const Light ramp = [](int x, int y, double t_us) { return std::exp(1e-3 * t_us + 0.01 * x * y); };
  const Run prompt = run(16, 16, p, 1, ramp, 0, 1000, 50'000);
  p.latency_us = 400;
  const Run late = run(16, 16, p, 1, ramp, 0, 1000, 50'000);
  REQUIRE(late.events.size() == prompt.events.size());
  for (std::size_t i = 0; i < late.events.size(); ++i)
    REQUIRE(late.events[i].t_us == prompt.events[i].t_us + 400);

  p.latency_jitter_us = 300;
  const Run jittered = run(16, 16, p, 1, ramp, 0, 1000, 50'000);
  REQUIRE(jittered.events.size() == prompt.events.size());
  REQUIRE(in_order(jittered.events));
  double sum = 0;
  double square = 0;
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 16; ++x) {
      const std::vector<Event> a = of_pixel(prompt.events, x, y);
      const std::vector<Event> b = of_pixel(jittered.events, x, y);
      REQUIRE(a.size() == b.size());
      for (std::size_t i = 0; i < a.size(); ++i) {
        const auto delay = static_cast<double>(b[i].t_us - a[i].t_us);
        REQUIRE(delay >= 0);
        sum += delay;
        square += delay * delay;
      }
    }
  }
  const auto n = static_cast<double>(prompt.events.size());
  const double mean = sum / n;
  // The lower bound and the kept order only push later; a fifth of the draws meets them.
  REQUIRE(mean > 400);
  REQUIRE(mean < 520);
  REQUIRE(std::sqrt(square / n - mean * mean) == Approx(270).margin(60));
}

TEST_CASE("drawn parameters stay in their ranges and are described whole; night changes only the night's") {
  for (std::uint64_t seed = 0; seed < 500; ++seed) {
    for (const bool night : {false, true}) {
      const DvsParameters p = draw_dvs_parameters(seed, night);
      REQUIRE((p.threshold_on >= 0.1 && p.threshold_on <= 1.0));
      REQUIRE((p.threshold_off >= 0.5 * p.threshold_on && p.threshold_off <= 1.4 * p.threshold_on));
      REQUIRE((p.threshold_spread >= 0.03 && p.threshold_spread <= 0.08));
      REQUIRE((p.refractory_us >= 0 && p.refractory_us <= 3000));
      REQUIRE((p.bandwidth_floor_hz >= 30 && p.bandwidth_hz <= (night ? 200 : 3000)));
      REQUIRE((p.leak_hz >= 0 && p.leak_hz <= 0.3));
      REQUIRE((p.shot_noise_hz >= 0 && p.shot_noise_hz <= 10));
      REQUIRE((p.hot_pixel_share >= 0 && p.hot_pixel_share <= 0.001));
      REQUIRE((p.latency_us >= 50 && p.latency_us <= 500));
      REQUIRE((p.latency_jitter_us > 0 && p.latency_jitter_us < p.latency_us));
      REQUIRE_NOTHROW(Dvs(2, 2, p, seed));
    }
    REQUIRE(draw_dvs_parameters(seed, true).threshold_on == draw_dvs_parameters(seed, false).threshold_on);
  }
  DvsParameters p;
  const std::vector<NamedValue> names = describe(p);
  REQUIRE(names.size() * sizeof(double) == sizeof(DvsParameters));
  p.latency_us = 77;
  for (const NamedValue& named : describe(p))
    if (named.name == "latency_us") REQUIRE(named.value == 77);
}

TEST_CASE("bad arguments are refused") {
  REQUIRE_THROWS_AS(Dvs(0, 5, {}, 1), std::invalid_argument);
  REQUIRE_THROWS_AS(Dvs(4096, 4096, {}, 1), std::invalid_argument);
  DvsParameters p;
  p.threshold_on = 0;
  REQUIRE_THROWS_AS(Dvs(5, 5, p, 1), std::invalid_argument);
  p = {};
  p.leak_hz = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_THROWS_AS(Dvs(5, 5, p, 1), std::invalid_argument);
  p = {};
  p.bandwidth_hz = 10;
  p.bandwidth_floor_hz = 11;
  REQUIRE_THROWS_AS(Dvs(5, 5, p, 1), std::invalid_argument);

  p = {};
  p.readout_events_per_s = 5;
  REQUIRE_THROWS_AS(Dvs(5, 5, p, 1), std::invalid_argument);

  Dvs dvs(2, 2, {}, 1);
  Workers workers(1);
  std::vector<Event> events;
  const std::vector<float> view(4, 1.0f);
  const LightView shown[] = {{100, view}, {100, view}};
  REQUIRE_THROWS_AS(dvs.show(shown, workers, events), std::invalid_argument);
  REQUIRE_NOTHROW(dvs.show({shown, 1}, workers, events));
  REQUIRE_THROWS_AS(dvs.show({shown, 1}, workers, events), std::invalid_argument);
  const LightView small{200, std::span(view).first(3)};
  REQUIRE_THROWS_AS(dvs.show({&small, 1}, workers, events), std::invalid_argument);
  const LightView distant{std::numeric_limits<std::int64_t>::max(), view};
  REQUIRE_THROWS_AS(dvs.show({&distant, 1}, workers, events), std::invalid_argument);
}
