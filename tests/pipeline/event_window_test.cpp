// The window against a std::deque of whole events.
#include "pipeline/event_window.hpp"

#include <catch2/catch.hpp>
#include <deque>
#include <random>
#include <vector>

#include "support/arena_block.hpp"

using namespace egofocus;

namespace {

// More than a second: where slices share a place.
constexpr std::int64_t kLong = std::int64_t{1} << 26;
constexpr Intrinsics kSensor{346, 260, 250, 250, 172.5, 129.5};
constexpr Intrinsics kLargest{1280, 1280, 900, 900, 639.5, 639.5};
constexpr Intrinsics kSmallest{8, 8, 8, 8, 3.5, 3.5};

WindowConfig small_window() {
  WindowConfig config;
  config.max_events = 100;
  config.min_events = 0;
  config.max_age_us = 20'000;
  return config;
}

// What the header promises, on 64-bit times.
std::vector<Event> expected(const std::deque<Event>& all, const WindowConfig& config, std::int64_t begin_us,
                            std::int64_t end_us) {
  const std::size_t held = std::min<std::size_t>(all.size(), static_cast<std::size_t>(config.max_events) * 4);
  std::vector<Event> in;
  for (std::size_t i = all.size() - held; i < all.size(); ++i) {
    const std::int64_t t = all[i].t_us;
    if (t >= begin_us && t <= end_us && end_us - t <= config.max_age_us) in.push_back(all[i]);
  }
  const auto n = static_cast<std::size_t>(config.max_events);
  if (in.size() <= n) return in;
  std::vector<Event> even;
  for (std::size_t i = 0; i < n; ++i) even.push_back(in[i * in.size() / n]);
  return even;
}

void check_walk(const EventWindow& window, const Intrinsics& sensor, const EventWindow::Selection& s,
                const std::vector<Event>& truth, std::uint32_t from) {
  EventWindow::Reader reader(window, s, from);
  for (std::uint32_t i = from; i < s.count; ++i) {
    const EventWindow::Selected e = reader.next();
    REQUIRE(e.pixel == static_cast<std::uint32_t>(truth[i].y * sensor.width_px + truth[i].x));
    REQUIRE(e.t_us == truth[i].t_us);
  }
}

// Also from the middle on, as a second part reads it, and from the last event.
void check_selection(const EventWindow& window, const Intrinsics& sensor, const std::vector<Event>& truth,
                     std::int64_t begin_us, std::int64_t end_us) {
  const EventWindow::Selection s = window.select(begin_us, end_us);
  REQUIRE(s.count == truth.size());
  if (s.count == 0) return;
  for (const std::uint32_t from : {0u, s.count / 2, s.count - 1}) check_walk(window, sensor, s, truth, from);
}

}  // namespace

TEST_CASE("selection is that of a deque with whole events, on any sensor, and at any time") {
  const Intrinsics sensor = GENERATE(kSensor, kLargest, kSmallest);
  const std::int64_t start_us =
      GENERATE(std::int64_t{0}, kLong - 60'000, 7 * kLong - 100'000, -kLong - 50'000);
  const unsigned spacing_us = GENERATE(20u, 150u, 900u);
  const WindowConfig config = small_window();
  test::RoomyArena arena;
  EventWindow window(config, sensor, *arena);
  std::deque<Event> all;
  std::mt19937 random(spacing_us);
  std::int64_t t_us = start_us;
  for (int tick = 0; tick < 60; ++tick) {
    const unsigned burst = static_cast<unsigned>(random() % 120);
    for (unsigned i = 0; i < burst; ++i) {
      t_us += static_cast<std::int64_t>(random() % spacing_us);
      const Event e{t_us, static_cast<std::uint16_t>(random() % static_cast<unsigned>(sensor.width_px)),
                    static_cast<std::uint16_t>(random() % static_cast<unsigned>(sensor.height_px)), 1};
      window.add(e);
      all.push_back(e);
    }
    if (random() % 8 == 0) t_us += static_cast<std::int64_t>(random() % 100'000);
    const std::int64_t end_us = t_us + static_cast<std::int64_t>(random() % 5000);
    const std::int64_t begin_us = end_us - static_cast<std::int64_t>(random() % 40'000);
    check_selection(window, sensor, expected(all, config, begin_us, end_us), begin_us, end_us);
  }
}

TEST_CASE("an event of a minute ago does not look young") {
  const WindowConfig config = small_window();
  const std::int64_t pause_us = GENERATE(kLong + 0, kLong + 10, kLong - 5, kLong + 19'999, kLong - 20'000);
  test::RoomyArena arena;
  EventWindow window(config, kSensor, *arena);
  std::deque<Event> all;
  for (std::int64_t t : {std::int64_t{1000}, std::int64_t{1005}, 1005 + pause_us, 1025 + pause_us}) {
    all.push_back({t, 1, 2, 0});
    window.add(all.back());
  }
  const std::int64_t end_us = 1030 + pause_us;
  check_selection(window, kSensor, expected(all, config, end_us - 20'000, end_us), end_us - 20'000, end_us);
  CHECK(window.select(end_us - 20'000, end_us).count == 2);
}

TEST_CASE("empty selections: nothing added, all too old, all too young") {
  test::RoomyArena arena;
  EventWindow window(small_window(), kSensor, *arena);
  CHECK(window.newest_us() == INT64_MIN);
  CHECK(window.select(0, 1000).count == 0);
  window.add({5000, 1, 1, 1});
  CHECK(window.select(5001, 9000).count == 0);
  CHECK(window.select(0, 4999).count == 0);
  CHECK(window.select(5000, 5000).count == 1);
  CHECK(window.select(5000, 25'000).count == 1);
  CHECK(window.select(5000, 25'001).count == 0);  // older than max_age_us
  CHECK(window.select(6000, 5500).count == 0);    // a window that ends before it begins
}

TEST_CASE("decimation keeps the oldest, the count, the order, and even steps") {
  const WindowConfig config = small_window();
  test::RoomyArena arena;
  EventWindow window(config, kLargest, *arena);
  const int added = GENERATE(101, 199, 250, 400, 1000);  // above 400 the store overflows
  for (int i = 0; i < added; ++i) window.add({i * 10, static_cast<std::uint16_t>(i), 0, 1});
  const EventWindow::Selection s = window.select(0, added * 10);
  const int held = std::min(added, 400);
  REQUIRE(s.in_window == static_cast<std::uint64_t>(held));
  REQUIRE(s.count == 100);
  EventWindow::Reader reader(window, s, 0);
  int last = static_cast<int>(reader.next().pixel);
  CHECK(last == added - held);
  int smallest = 1000;
  int largest = 0;
  for (std::uint32_t i = 1; i < s.count; ++i) {
    const int x = static_cast<int>(reader.next().pixel);
    const int step = x - last;
    last = x;
    smallest = std::min(smallest, step);
    largest = std::max(largest, step);
  }
  CHECK(smallest == held / 100);
  CHECK(largest <= (held + 99) / 100);
}

TEST_CASE("an event takes three bytes, and a slice of time four") {
  WindowConfig config;
  config.max_events = 80'000;
  Arena counter;
  const EventWindow window(config, kSensor, counter);
  CHECK(counter.used_bytes() == 4 * 80'000 * 3 + 8192 * 4);
}

TEST_CASE("a window that cannot be meant is refused") {
  WindowConfig config;
  CHECK(EventWindow::check(config).ok());
  SECTION("few") {
    config.max_events = 99;
  }
  SECTION("many") {
    config.max_events = 1'000'001;
  }
  SECTION("negative minimum") {
    config.min_events = -1;
  }
  SECTION("minimum above maximum") {
    config.min_events = config.max_events + 1;
  }
  SECTION("short") {
    config.max_age_us = 999;
  }
  SECTION("long") {
    config.max_age_us = 1'000'001;
  }
  CHECK(EventWindow::check(config).code() == StatusCode::kBadWindow);
}
