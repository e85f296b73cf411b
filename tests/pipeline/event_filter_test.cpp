// The filter against a naive one that keeps whole histories and asks them plainly.
#include "pipeline/event_filter.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>
#include <vector>

#include "support/arena_block.hpp"

using namespace egofocus;

namespace {

Config small_sensor() {
  Config config;
  config.camera.intrinsics = {24, 17, 30, 30, 12, 8};
  return config;
}

enum class Fate { kKept, kRange, kOrder, kHot, kRefractory, kIsolated };

// Remembers everything, looks through all of it.
class NaiveFilter {
 public:
  explicit NaiveFilter(const Config& config) : config_(config) {
    hot_.assign(config.filter.hot_pixels.begin(), config.filter.hot_pixels.end());
  }

  Fate fate(const Event& e) {
    const FilterConfig& f = config_.filter;
    if (e.x >= config_.camera.intrinsics.width_px || e.y >= config_.camera.intrinsics.height_px)
      return Fate::kRange;
    if (any_ && e.t_us < newest_us_) return Fate::kOrder;
    if (!any_) first_us_ = e.t_us;
    any_ = true;
    newest_us_ = e.t_us;
    if (f.hot_pixel_rate_hz > 0) {
      learnt_.push_back(e);
      const auto stretch = [&](const Event& event) {
        return (event.t_us - first_us_) / f.hot_pixel_learn_us;
      };
      std::int64_t now = 0;
      std::int64_t before = 0;
      for (const Event& other : learnt_) {
        if (other.x != e.x || other.y != e.y) continue;
        now += stretch(other) == stretch(e);
        before += stretch(other) + 1 == stretch(e);
      }
      if (std::max(now, before) > f.hot_pixel_rate_hz * f.hot_pixel_learn_us / 1'000'000) return Fate::kHot;
    }
    for (const Pixel& p : hot_) {
      if (p.x == e.x && p.y == e.y) return Fate::kHot;
    }
    for (const Event& other : kept_) {
      if (f.refractory_us > 0 && other.x == e.x && other.y == e.y && e.t_us - other.t_us < f.refractory_us)
        return Fate::kRefractory;
    }
    if (f.isolated_us > 0) {
      bool company = false;
      for (const Event& other : seen_) {
        const int dx = std::abs(other.x - e.x);
        const int dy = std::abs(other.y - e.y);
        company |= dx <= 1 && dy <= 1 && dx + dy > 0 && e.t_us - other.t_us <= f.isolated_us;
      }
      seen_.push_back(e);
      if (!company) return Fate::kIsolated;
    }
    kept_.push_back(e);
    return Fate::kKept;
  }

 private:
  Config config_;
  bool any_ = false;
  std::int64_t newest_us_ = 0;
  std::int64_t first_us_ = 0;
  std::vector<Pixel> hot_;
  std::vector<Event> learnt_;
  std::vector<Event> kept_;
  std::vector<Event> seen_;
};

void compare(const Config& config, std::uint32_t seed) {
  REQUIRE(EventFilter::check(config).ok());
  test::RoomyArena arena;
  EventFilter filter(config, *arena);
  NaiveFilter naive(config);
  std::mt19937 random(seed);
  std::uint64_t fates[6] = {};
  std::int64_t t_us = -500;  // across zero: nothing is special there
  const std::uint64_t total = 4000;
  for (std::uint64_t i = 0; i < total; ++i) {
    t_us += static_cast<std::int64_t>(random() % 40);
    Event e;
    e.t_us = random() % 50 == 0 ? t_us - static_cast<std::int64_t>(random() % 300) : t_us;
    e.x = static_cast<std::uint16_t>(random() % 25);
    e.y = static_cast<std::uint16_t>(random() % 18);
    if (random() % 40 == 0) e.x = 65535;
    if (random() % 3 == 0 && (i / 500) % 3 != 1) {  // one pixel that shouts, with pauses
      e.x = 5;
      e.y = 0;
    }
    const Fate expected = naive.fate(e);
    ++fates[static_cast<int>(expected)];
    const bool kept = filter.keep(e);
    REQUIRE(kept == (expected == Fate::kKept));
  }
  const EventCounters& c = filter.counters();
  CHECK(c.kept == fates[0]);
  CHECK(c.out_of_range == fates[1]);
  CHECK(c.out_of_order == fates[2]);
  CHECK(c.hot_pixel == fates[3]);
  CHECK(c.refractory == fates[4]);
  CHECK(c.isolated == fates[5]);
  CHECK(c.kept + c.out_of_range + c.out_of_order + c.hot_pixel + c.refractory + c.isolated == total);
}

}  // namespace

TEST_CASE("each stage of the event filter, alone and together, does what the naive one does") {
  Config config = small_sensor();
  const Pixel given[] = {{3, 4}, {23, 16}, {0, 0}};
  const std::uint32_t seed = GENERATE(1u, 2u, 3u);
  SECTION("range and order alone") {}
  SECTION("refractory") {
    config.filter.refractory_us = 700;
  }
  SECTION("isolated") {
    config.filter.isolated_us = 400;
  }
  SECTION("hot pixels given") {
    config.filter.hot_pixels = given;
  }
  SECTION("hot pixels learnt") {
    config.filter.hot_pixel_rate_hz = 1000;
    config.filter.hot_pixel_learn_us = 30'000;
  }
  SECTION("all") {
    config.filter.refractory_us = 900;
    config.filter.isolated_us = 500;
    config.filter.hot_pixels = given;
    config.filter.hot_pixel_rate_hz = 2000;
    config.filter.hot_pixel_learn_us = 20'000;
  }
  compare(config, seed);
}

TEST_CASE("an isolated event does not start a refractory time: only a kept one does") {
  Config config = small_sensor();
  config.filter.refractory_us = 1000;
  config.filter.isolated_us = 1000;
  test::RoomyArena arena;
  EventFilter filter(config, *arena);
  CHECK_FALSE(filter.keep({0, 10, 10, 1}));  // alone
  CHECK(filter.keep({10, 11, 10, 1}));       // its neighbour
  CHECK(filter.keep({20, 10, 10, 1}));       // was never kept before
  CHECK_FALSE(filter.keep({30, 10, 10, 1}));
  CHECK(filter.counters().isolated == 1);
  CHECK(filter.counters().refractory == 1);
}

TEST_CASE("bounds of refractory and isolated times are as documented") {
  Config config = small_sensor();
  SECTION("exactly the refractory time later is kept") {
    config.filter.refractory_us = 100;
    test::RoomyArena arena;
    EventFilter filter(config, *arena);
    CHECK(filter.keep({0, 1, 1, 1}));
    CHECK_FALSE(filter.keep({99, 1, 1, 1}));
    CHECK(filter.keep({100, 1, 1, 1}));
  }
  SECTION("exactly the isolated time later still is company; a corner has only three neighbours") {
    config.filter.isolated_us = 100;
    test::RoomyArena arena;
    EventFilter filter(config, *arena);
    CHECK_FALSE(filter.keep({0, 1, 1, 1}));
    CHECK(filter.keep({100, 0, 0, 1}));
    CHECK_FALSE(filter.keep({201, 1, 0, 1}));
    CHECK_FALSE(filter.keep({202, 23, 3, 1}));
    CHECK_FALSE(filter.keep({203, 0, 4, 1}));  // the other end of the neighbouring row is no neighbour
  }
}

TEST_CASE("a filter that cannot be meant is refused") {
  Config config = small_sensor();
  const Pixel outside[] = {{24, 0}};
  const auto code = [&] { return EventFilter::check(config).code(); };
  CHECK(code() == StatusCode::kOk);
  SECTION("negative refractory") {
    config.filter.refractory_us = -1;
  }
  SECTION("endless refractory") {
    config.filter.refractory_us = 10'000'001;
  }
  SECTION("negative isolated") {
    config.filter.isolated_us = -1;
  }
  SECTION("negative rate") {
    config.filter.hot_pixel_rate_hz = -1;
  }
  SECTION("learning for no time") {
    config.filter.hot_pixel_rate_hz = 10000;
    config.filter.hot_pixel_learn_us = 999;
  }
  SECTION("a rate below one event in the time of learning would mask every pixel") {
    config.filter.hot_pixel_rate_hz = 9;
    config.filter.hot_pixel_learn_us = 100'000;
  }
  SECTION("a hot pixel outside the sensor") {
    config.filter.hot_pixels = outside;
  }
  CHECK(code() == StatusCode::kBadFilter);
}
