// The tick grid against exact integer arithmetic, and a clock that oversleeps by script.
#include "pipeline/scheduler.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

using namespace egofocus;

namespace {

// Sleeps to the asked time plus the next overshoot of the script.
struct ScriptedClock {
  std::int64_t now_us = 0;
  std::vector<std::int64_t> overshoots;
  std::size_t next = 0;
  int sleeps = 0;

  Clock clock() {
    return {this, [](void* self) noexcept { return static_cast<ScriptedClock*>(self)->now_us; },
            [](void* self, std::int64_t t_us) noexcept {
              auto& c = *static_cast<ScriptedClock*>(self);
              ++c.sleeps;
              c.now_us = t_us + (c.next < c.overshoots.size() ? c.overshoots[c.next++] : 0);
            }};
  }
};

const std::atomic<bool> kGoesOn{false};

}  // namespace

TEST_CASE("a million ticks do not drift, whatever the rate") {
  struct Rate {
    double hz;
    std::int64_t per_period;  // rate = ticks / per_period exactly: ticks in `seconds`
    std::int64_t seconds;
  };
  for (const Rate rate :
       {Rate{30, 30, 1}, Rate{29.97, 2997, 100}, Rate{20, 20, 1}, Rate{7, 7, 1}, Rate{1000, 1000, 1}}) {
    Scheduler scheduler;
    RateConfig config;
    config.rate_hz = rate.hz;
    scheduler.start(config, 123'456'789);
    std::int64_t worst = 0;
    for (std::int64_t k = 0; k < 1'000'000; ++k) {
      const std::int64_t truth = 123'456'789 + k * rate.seconds * 1'000'000 / rate.per_period;
      worst = std::max(worst, std::abs(scheduler.tick_us() - truth));
      scheduler.advance();
    }
    INFO(rate.hz << " Hz");
    // 29.97 has no exact double: the quotient may lie just beside a whole microsecond.
    CHECK(worst <= (rate.per_period == 2997 ? 1 : 0));
  }
}

TEST_CASE("a late tick takes the next grid point, and never a burst") {
  Scheduler scheduler;
  RateConfig config;
  config.rate_hz = 100;
  config.lateness_us = 2000;
  scheduler.start(config, 50'000);
  CHECK(scheduler.tick_us() == 50'000);
  CHECK(scheduler.deadline_us() == 52'000);
  CHECK(scheduler.advance(52'000) == 0);
  CHECK(scheduler.tick_us() == 60'000);
  CHECK(scheduler.advance(72'000) == 0);  // the next one is due right now: not late
  CHECK(scheduler.tick_us() == 70'000);
  CHECK(scheduler.advance(82'001) == 1);  // the next one was due a microsecond ago
  CHECK(scheduler.tick_us() == 90'000);
  CHECK(scheduler.advance(1'000'000) == 90);
  CHECK(scheduler.tick_us() == 1'000'000);
  CHECK(scheduler.advance(0) == 0);  // far too early moves by one all the same
  CHECK(scheduler.index() == 96);
}

TEST_CASE("advance finds the first point that is not past, for any rate and delay") {
  for (double hz : {0.1, 7.0, 29.97, 30.0, 59.94, 333.0, 1000.0}) {
    RateConfig config;
    config.rate_hz = hz;
    for (std::int64_t delay_us :
         {std::int64_t{1}, std::int64_t{999}, std::int64_t{33'333}, std::int64_t{33'334},
          std::int64_t{10'000'000}, std::int64_t{86'400'000'000}}) {
      Scheduler scheduler;
      scheduler.start(config, -7);
      const std::uint64_t skipped = scheduler.advance(-7 + delay_us);
      INFO(hz << " Hz, " << delay_us);
      CHECK(scheduler.index() == skipped + 1);
      CHECK(scheduler.deadline_us() >= -7 + delay_us);
      if (scheduler.index() > 1) {
        Scheduler before;
        before.start(config, -7);
        for (std::uint64_t k = 0; k + 1 < scheduler.index(); ++k) before.advance();
        CHECK(before.deadline_us() < -7 + delay_us);
      }
    }
  }
}

TEST_CASE("wait sleeps to the absolute deadline and reports the overshoot") {
  ScriptedClock clock;
  clock.overshoots = {0, 150, 12'000, 0};
  Scheduler scheduler;
  RateConfig config;
  config.rate_hz = 100;
  scheduler.start(config, 10'000);
  CHECK(scheduler.wait(clock.clock(), kGoesOn) == 0);
  CHECK(scheduler.advance(clock.now_us) == 0);
  CHECK(scheduler.wait(clock.clock(), kGoesOn) == 150);
  CHECK(scheduler.advance(clock.now_us) == 0);
  CHECK(scheduler.wait(clock.clock(), kGoesOn) == 12'000);  // now = 42'000
  CHECK(scheduler.advance(clock.now_us) == 1);              // 40'000 is past
  CHECK(scheduler.tick_us() == 50'000);
  CHECK(scheduler.wait(clock.clock(), kGoesOn) == 0);
  CHECK(clock.sleeps == 4);
  clock.now_us = 75'000;
  scheduler.advance();
  CHECK(scheduler.wait(clock.clock(), kGoesOn) == 15'000);  // already late: no sleep at all
  CHECK(clock.sleeps == 4);
}

TEST_CASE("a long wait is cut into pieces, and ends soon after it was told to") {
  ScriptedClock clock;
  Scheduler scheduler;
  RateConfig config;
  config.rate_hz = 0.1;
  scheduler.start(config, 10'000'000);
  std::atomic<bool> stopping{true};
  CHECK(scheduler.wait(clock.clock(), stopping) == -10'000'000);
  CHECK(clock.sleeps == 0);
  stopping = false;
  CHECK(scheduler.wait(clock.clock(), stopping) == 0);
  CHECK(clock.sleeps == 200);
}

TEST_CASE("a tick that would begin too late gives way to the newest one due") {
  const std::int64_t period_us = 20'000, lateness_us = 3'000;
  Scheduler scheduler;
  RateConfig config;
  config.rate_hz = 50;
  config.lateness_us = lateness_us;
  for (std::int64_t now_us = lateness_us; now_us < 500'000; now_us += 997) {
    scheduler.start(config, 0);
    const std::int64_t due =
        (now_us - lateness_us) / period_us;  // number of the newest one, as integers see it
    CHECK(scheduler.catch_up(now_us) == static_cast<std::uint64_t>(due));
    CHECK(scheduler.tick_us() == due * period_us);
  }
  scheduler.start(config, 0);
  CHECK(scheduler.catch_up(40 * period_us + lateness_us) == 40);  // due at this very moment
}

TEST_CASE("the monotonic clock does not go back, and sleeps at least as long as asked") {
  const Clock clock = monotonic_clock();
  const std::int64_t start_us = clock.now_us(clock.self);
  std::int64_t before = start_us;
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t now = clock.now_us(clock.self);
    REQUIRE(now >= before);
    before = now;
  }
  const std::int64_t until = clock.now_us(clock.self) + 5000;
  clock.sleep_until_us(clock.self, until);
  CHECK(clock.now_us(clock.self) >= until);
  clock.sleep_until_us(clock.self, until - 1'000'000);  // the past: returns at once
  CHECK(clock.now_us(clock.self) < until + 10'000'000);
}

TEST_CASE("the grid goes on from where it was moved to") {
  Scheduler scheduler;
  RateConfig config;
  config.rate_hz = 30;
  scheduler.start(config, 1000);
  scheduler.advance();
  scheduler.advance();
  scheduler.move_to(500'000);
  CHECK(scheduler.tick_us() == 500'000);
  CHECK(scheduler.index() == 2);
  scheduler.advance();
  CHECK(scheduler.tick_us() == 533'333);
  scheduler.advance();
  CHECK(scheduler.tick_us() == 566'666);
  CHECK(scheduler.advance(10'500'000) == 297);  // 500'000 + 300 periods is due right then
  CHECK(scheduler.tick_us() == 10'500'000);
  CHECK(scheduler.index() == 302);
  scheduler.start(config, 7);
  CHECK(scheduler.tick_us() == 7);
}

TEST_CASE("a rate that cannot be kept is refused") {
  RateConfig config;
  CHECK(Scheduler::check(config).ok());
  for (double bad : {0.0, -1.0, 0.09, 1000.1, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    config.rate_hz = bad;
    CHECK(Scheduler::check(config).code() == StatusCode::kBadRate);
  }
  config.rate_hz = 20;
  for (std::int64_t bad : {std::int64_t{-1}, std::int64_t{1'000'001}}) {
    config.lateness_us = bad;
    CHECK(Scheduler::check(config).code() == StatusCode::kBadRate);
  }
}
