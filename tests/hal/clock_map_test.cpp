// The map against simulated clocks: the truth is known, the delays are one-sided.
#include "hal/clock_map.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>

using egofocus::ClockMap;

namespace {

constexpr double kSecond = 1e6;

// Device time of a host time, and the pairs that a transport makes of it.
struct Clocks {
  double drift_ppm = 50;  // the host's clock is faster
  double device_begin_us = 123456789;
  double host_begin_us = 987654321012;

  [[nodiscard]] std::int64_t device_us(double since_us) const {
    return std::llround(device_begin_us + since_us / (1 + drift_ppm * 1e-6));
  }
  [[nodiscard]] double host_us(double since_us) const { return host_begin_us + since_us; }
};

using Delay = std::function<double(std::mt19937_64&, double since_us)>;

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// Runs pairs of a period through the map; each in the order of use: observe, then ask for the times since the
// last pair.
struct Run {
  ClockMap map;
  std::int64_t worst_error_us = 0;
  std::int64_t last_mapped_us = INT64_MIN;
  bool monotone = true;

  void pairs(const Clocks& clocks, const Delay& delay, std::mt19937_64& random, double from_us, double to_us,
             double period_us, double judge_from_us) {
    for (double t = from_us; t < to_us; t += period_us) {
      map.observe(clocks.device_us(t), static_cast<std::int64_t>(clocks.host_us(t) + delay(random, t)));
      for (const double back : {0.8, 0.4, 0.0}) {
        const double at = t - back * period_us;
        const std::int64_t mapped = map.to_host_us(clocks.device_us(at));
        monotone = monotone && mapped >= last_mapped_us;
        last_mapped_us = mapped;
        if (t < judge_from_us) continue;
        const std::int64_t error = std::llabs(mapped - std::llround(clocks.host_us(at)));
        worst_error_us = std::max(worst_error_us, error);
      }
    }
  }
};

struct NamedDelay {
  const char* name;
  Delay delay;
};

// All within 5 ms or about as wide, never negative.
const NamedDelay kDelays[] = {
    {"uniform 0..5 ms", [](auto& r, double) { return uniform(r, 0, 5000); }},
    {"exponential, mean 1.7 ms", [](auto& r, double) { return -1700 * std::log(uniform(r, 1e-12, 1)); }},
    {"half normal, 2 ms", [](auto& r, double) { return std::fabs(std::normal_distribution<>(0, 2000)(r)); }},
    {"triangular, rare at its minimum",
     [](auto& r, double) { return uniform(r, 0, 2500) + uniform(r, 0, 2500); }},
    {"one in ten quick, else 4..5 ms",
     [](auto& r, double) { return uniform(r, 0, 1) < 0.1 ? uniform(r, 0, 500) : uniform(r, 4000, 5000); }},
    {"USB frames of 1 ms, up to 5",
     [](auto& r, double) { return 1000 * std::floor(uniform(r, 0, 5)) + uniform(r, 0, 125); }},
    {"loaded every other 3 s: never below 3 ms then",
     [](auto& r, double t) { return std::fmod(t, 6e6) < 3e6 ? uniform(r, 0, 500) : uniform(r, 3000, 5000); }},
    {"one stall of 100 ms a second",
     [](auto& r, double t) {
       return std::fmod(t, 1e6) < 1e5 ? 1e5 - std::fmod(t, 1e6) : uniform(r, 0, 5000);
     }},
};

}  // namespace

TEST_CASE("clock map: 50 ppm of drift and 5 ms of jitter leave 0.3 ms after 10 s") {
  for (const NamedDelay& d : kDelays) {
    for (const double drift : {50.0, -50.0, 0.0, 120.0}) {
      for (const double period_us : {1000.0, 4000.0}) {
        Clocks clocks;
        clocks.drift_ppm = drift;
        std::mt19937_64 random(7);
        Run run;
        run.pairs(clocks, d.delay, random, 0, 60 * kSecond, period_us, 10 * kSecond);
        INFO(d.name << ", drift " << drift << " ppm, a pair each " << period_us << " us: worst error "
                    << run.worst_error_us << " us, drift found " << run.map.drift_ppm());
        CHECK(run.worst_error_us <= 300);
        CHECK(run.monotone);
        CHECK(run.map.settled());
        CHECK(run.map.drift_ppm() == Approx(drift).margin(10));
        CHECK(run.map.counters().jumps == 0);
        CHECK(run.map.counters().pairs == run.map.counters().used + run.map.counters().outliers);
      }
    }
  }
}

TEST_CASE("clock map: before it is settled it never errs by more than the jitter") {
  for (const NamedDelay& d : kDelays) {
    std::mt19937_64 random(11);
    Run run;
    run.pairs({}, d.delay, random, 0, 0.9 * kSecond, 1000, 0);
    INFO(d.name << ": worst error " << run.worst_error_us);
    CHECK_FALSE(run.map.settled());
    CHECK(run.monotone);
    CHECK((run.worst_error_us <= 6000 || std::string(d.name).find("exponential") == 0 ||
           std::string(d.name).find("stall") != std::string::npos));
  }
}

TEST_CASE("clock map: exact clocks and no delay give the exact time") {
  Run run;
  std::mt19937_64 random(1);
  Clocks clocks;
  clocks.drift_ppm = 0;
  run.pairs(
      clocks, [](auto&, double) { return 0.0; }, random, 0, 5 * kSecond, 500, 0);
  CHECK(run.worst_error_us <= 1);
  CHECK(run.map.drift_ppm() == 0);
  CHECK(run.map.delay_us() == 0);
}

TEST_CASE("clock map: a day, and clocks that have run for years") {
  Clocks clocks;
  clocks.drift_ppm = -83;
  clocks.device_begin_us = 1.8e15;  // since 1970
  clocks.host_begin_us = -1e15;
  std::mt19937_64 random(3);
  Run run;
  run.pairs(clocks, kDelays[0].delay, random, 0, 86400 * kSecond, 20000, 60 * kSecond);
  INFO("worst error " << run.worst_error_us);
  CHECK(run.worst_error_us <= 600);  // a pair each 20 ms
  CHECK(run.monotone);
  CHECK(run.map.drift_ppm() == Approx(-83).margin(5));
}

TEST_CASE("clock map: a drift that changes is followed") {
  std::mt19937_64 random(5);
  Run run;
  // Temperature: 0 to 40 ppm within ten minutes. Truth is the sum of the steps.
  double host = 0;
  std::int64_t worst = 0;
  for (std::int64_t device = 0; device < 600'000'000; device += 1000) {
    host += 1000 * (1 + 40e-6 * static_cast<double>(device) / 6e8);
    run.map.observe(device, static_cast<std::int64_t>(host + uniform(random, 0, 5000)));
    if (device > 10'000'000)
      worst = std::max<std::int64_t>(worst, std::llabs(run.map.to_host_us(device) - std::llround(host)));
  }
  INFO("worst error " << worst);
  CHECK(worst <= 300);
}

TEST_CASE("clock map: pauses of any length are no jump") {
  for (const double pause_s : {1.0, 20.0, 60.0, 600.0, 3600.0}) {
    std::mt19937_64 random(9);
    Clocks clocks;
    Run run;
    run.pairs(clocks, kDelays[0].delay, random, 0, 40 * kSecond, 1000, 10 * kSecond);
    const double after = (40 + pause_s) * kSecond;
    // What the rate does not know grows with the pause: 0.5 us a second is half a ppm.
    run.pairs(clocks, kDelays[0].delay, random, after, after + 5 * kSecond, 1000, 1e18);
    CHECK(run.monotone);
    run.pairs(clocks, kDelays[0].delay, random, after + 5 * kSecond, after + 20 * kSecond, 1000, 0);
    INFO("pause of " << pause_s << " s: worst error " << run.worst_error_us);
    CHECK(run.worst_error_us <= 300);
    CHECK(run.map.counters().jumps == 0);
    CHECK(run.map.counters().outliers == 0);
  }
}

TEST_CASE("clock map: a jump of the device's clock is found, counted, and mended") {
  for (const double jump_us : {5e6, -5e6, 30e3, -30e3, 4e12, -123456789.0}) {
    std::mt19937_64 random(13);
    Clocks clocks;
    Run run;
    run.pairs(clocks, kDelays[0].delay, random, 0, 20 * kSecond, 1000, 10 * kSecond);
    clocks.device_begin_us += jump_us;
    run.last_mapped_us = INT64_MIN;
    // Mended after the half second that shows it, and good again within three more.
    run.pairs(clocks, kDelays[0].delay, random, 20 * kSecond, 20.51 * kSecond, 1000, 1e18);
    INFO("jump of " << jump_us << " us");
    CHECK(run.map.counters().jumps == 1);
    CHECK_FALSE(run.map.settled());
    run.last_mapped_us = INT64_MIN;
    run.monotone = true;
    run.pairs(clocks, kDelays[0].delay, random, 20.51 * kSecond, 40 * kSecond, 1000, 24 * kSecond);
    INFO("worst error " << run.worst_error_us);
    CHECK(run.worst_error_us <= 300);
    CHECK(run.monotone);
    CHECK(run.map.counters().jumps == 1);
    CHECK(run.map.counters().outliers >= 500);
    CHECK(run.map.counters().outliers <= 510);
  }
}

TEST_CASE("clock map: single wrong times change nothing") {
  std::mt19937_64 random(17);
  const Clocks clocks;
  Run run;
  run.pairs(clocks, kDelays[0].delay, random, 0, 20 * kSecond, 1000, 10 * kSecond);
  for (int i = 0; i < 40; ++i) {
    const double t = (20 + i) * kSecond;
    run.map.observe(clocks.device_us(t) + 77'000'000'000, std::llround(clocks.host_us(t)));
    run.map.observe(clocks.device_us(t) - 50'000'000, std::llround(clocks.host_us(t)));
    run.map.observe(INT64_MIN, std::llround(clocks.host_us(t)));
    run.map.observe(clocks.device_us(t), INT64_MAX);
    run.pairs(clocks, kDelays[0].delay, random, t, t + kSecond, 1000, 0);
  }
  CHECK(run.worst_error_us <= 300);
  CHECK(run.monotone);
  CHECK(run.map.counters().jumps == 0);
  CHECK(run.map.counters().outliers == 80);
  CHECK(run.map.counters().invalid == 80);
  run.map.observe(clocks.device_us(59 * kSecond), std::llround(clocks.host_us(60 * kSecond)));
  CHECK(run.map.counters().outliers == 81);  // a second back
  run.map.observe(clocks.device_us(60 * kSecond) - 9000, std::llround(clocks.host_us(60 * kSecond)));
  CHECK(run.map.counters().backwards == 1);
}

TEST_CASE("clock map: reset forgets all but the counters") {
  std::mt19937_64 random(19);
  Run run;
  CHECK(run.map.to_host_us(42) == 42);
  run.pairs({}, kDelays[0].delay, random, 0, 5 * kSecond, 1000, 1e18);
  run.map.reset();
  CHECK(run.map.counters().resets == 1);
  CHECK(run.map.counters().used == 5000);
  CHECK(run.map.drift_ppm() == 0);
  CHECK_FALSE(run.map.settled());
  CHECK(run.map.to_host_us(42) == 42);
  run.map.observe(1000, 7'000'000);
  CHECK(run.map.to_host_us(1000) == 7'000'000);
  CHECK(run.map.to_host_us(1500) == 7'000'500);
}

TEST_CASE("clock map: hostile times: no overflow, still monotone") {
  std::mt19937_64 random(23);
  ClockMap map;
  std::int64_t device = -ClockMap::kMaxTimeUs;
  std::int64_t host = ClockMap::kMaxTimeUs;
  for (int i = 0; i < 200000; ++i) {
    map.observe(device, host);
    switch (random() % 16) {
      case 0:
        device = static_cast<std::int64_t>(random());
        break;
      case 1:
        host = static_cast<std::int64_t>(random());
        break;
      default:
        device = static_cast<std::int64_t>(static_cast<std::uint64_t>(device) + random() % 400000);
        host = static_cast<std::int64_t>(static_cast<std::uint64_t>(host) + random() % 400000 - 19999);
    }
    std::int64_t last = INT64_MIN;
    const std::int64_t at = map.to_host_us(device);
    for (const std::int64_t t : {INT64_MIN, device / 2, device, INT64_MAX}) {
      if (t == device / 2 && device < 0) continue;
      const std::int64_t mapped = map.to_host_us(t);
      CHECK(mapped >= last);
      last = mapped;
    }
    (void)at;
  }
}
