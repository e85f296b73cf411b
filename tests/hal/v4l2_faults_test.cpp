// A V4L2 stream that fails: signals, poll errors, a device that goes away, one that comes back.
#include <poll.h>

#include "hal/v4l2_bench.hpp"

using namespace egofocus;
using Columns = std::vector<int>;

TEST_CASE("V4L2: signals interrupt nothing, and are not retried without end") {
  V4l2Bench bench;
  bench.kernel.errors[VIDIOC_REQBUFS] = {EINTR, EINTR};
  bench.kernel.errors[VIDIOC_STREAMON] = {EINTR};
  bench.start_with_clock();
  bench.kernel.frame(evt3_event(100, 1, 5));
  bench.kernel.waits = {-EINTR};
  bench.poll();
  CHECK(bench.columns().empty());
  bench.kernel.errors[VIDIOC_DQBUF] = {EINTR, EINTR};
  bench.poll();
  CHECK(bench.columns() == Columns{1});
  bench.kernel.frame(evt3_event(200, 2, 5));
  bench.kernel.errors[VIDIOC_DQBUF] = std::deque<int>(30, EINTR);
  for (int i = 0; i < 10; ++i) bench.poll();
  CHECK(bench.columns() == Columns{2});
  CHECK(bench.source->counters().lost == 0);
}

TEST_CASE("V4L2: a poll error with buffers behind it is no end, and one without is waited out") {
  V4l2Bench bench;
  bench.start_with_clock();
  bench.kernel.frame(evt3_event(100, 1, 5));
  bench.kernel.waits = {POLLERR};
  bench.poll();
  CHECK(bench.columns() == Columns{1});
  CHECK(bench.source->counters().poll_errors == 0);
  const std::int64_t before_us = bench.kernel.time.now_us();
  bench.kernel.waits = {POLLERR, POLLERR};
  bench.poll();
  bench.poll();
  CHECK(bench.source->counters().poll_errors == 2);
  CHECK(bench.kernel.time.now_us() - before_us == 2000);
  bench.kernel.frame(evt3_event(3000, 2, 5));
  bench.poll();
  CHECK(bench.columns() == Columns{2});
  CHECK(bench.source->counters().lost == 0);
}

TEST_CASE("V4L2: poll errors without end are a loss") {
  V4l2CameraSettings settings = V4l2Bench::small();
  settings.reopen = false;
  V4l2Bench bench(settings);
  bench.start_with_clock();
  bench.kernel.waits = std::deque<int>(100, POLLERR);
  Delivery told;
  int polls = 0;
  for (; polls < 1000 && told.status.ok(); ++polls) told = bench.poll();
  CHECK(polls == 100);
  CHECK(told.status.code() == StatusCode::kDeviceLost);
  CHECK(told.status.value() == EIO);
}

TEST_CASE(
    "V4L2: a device that goes away is found again with growing pauses, and nothing stays open meanwhile") {
  const int error = GENERATE(ENODEV, EIO);
  V4l2Bench bench;
  bench.start_with_clock();
  const std::int64_t gone_us = bench.kernel.time.now_us();
  bench.kernel.fail(error);
  CHECK(bench.poll().status.ok());
  CHECK(bench.kernel.open_files == 0);
  CHECK(bench.kernel.mapped == 0);
  CHECK_FALSE(bench.source->counters().is_streaming);
  CHECK(bench.source->counters().last_error.code() == StatusCode::kDeviceLost);
  CHECK(bench.source->counters().last_error.value() == error);

  bench.kernel.open_errors["/dev/media0"] = ENOENT;
  std::vector<std::int64_t> tries_us;
  std::uint64_t refused = 0;
  while (bench.kernel.time.now_us() < gone_us + 9'000'000) {
    const std::int64_t at_us = bench.kernel.time.now_us();
    CHECK(bench.poll(10'000).status.ok());
    CHECK(bench.kernel.time.now_us() - at_us <= 10'000);
    if (bench.source->counters().refused == refused) continue;
    refused = bench.source->counters().refused;
    tries_us.push_back(at_us - gone_us);
  }
  CHECK(tries_us ==
        std::vector<std::int64_t>{100'000, 300'000, 700'000, 1'500'000, 3'100'000, 5'100'000, 7'100'000});
  CHECK(bench.source->counters().last_error.code() == StatusCode::kNoDevice);
  CHECK(bench.kernel.open_files == 0);

  bench.kernel.open_errors.clear();
  bench.kernel.sequence = 0;
  for (int i = 0; i < 20; ++i) bench.poll(10'000);
  REQUIRE(bench.source->counters().is_streaming);
  // The sensor's time began anew, and the first frame gives the map.
  bench.kernel.frame(evt3_event(50, 9, 5));
  bench.poll();
  CHECK(bench.columns().empty());
  const std::int64_t back_us = bench.kernel.time.now_us();
  bench.pass(1000);
  bench.kernel.frame(evt3_event(1050, 10, 5));
  bench.poll();
  const std::vector<Event> events = bench.events();
  REQUIRE(events.size() == 1);
  CHECK(events[0].t_us == back_us + 1000);
  const V4l2CameraCounters counters = bench.source->counters();
  CHECK(counters.opened == 2);
  CHECK(counters.lost == 1);
  CHECK(counters.samples.unmapped == 1);
  CHECK(counters.lost_buffers == 0);
}

TEST_CASE("V4L2: unplugged and back twenty times, no file and no mapping is left behind") {
  V4l2Bench bench;
  bench.start();
  for (int i = 0; i < 20; ++i) {
    bench.kernel.frame(evt3_event(1, 1, 1));
    bench.poll();
    bench.kernel.fail(ENODEV);
    bench.poll();
    for (int n = 0; n < 100 && !bench.source->counters().is_streaming; ++n) bench.poll();
    REQUIRE(bench.source->counters().is_streaming);
  }
  CHECK(bench.source->counters().lost == 20);
  CHECK(bench.source->counters().opened == 21);
  CHECK(bench.kernel.open_files == 1);
  CHECK(bench.kernel.mapped == 4);
  bench.source->stop();
  CHECK(bench.kernel.open_files == 0);
  CHECK(bench.kernel.mapped == 0);
  CHECK_FALSE(bench.kernel.is_streaming);
}

TEST_CASE("V4L2: a loss without re-opening is the source's status from then on") {
  V4l2CameraSettings settings = V4l2Bench::small();
  settings.reopen = false;
  V4l2Bench bench(settings);
  bench.start_with_clock();
  bench.kernel.fail(ENODEV);
  for (int i = 0; i < 3; ++i) {
    const Delivery told = bench.poll();
    CHECK(told.status.code() == StatusCode::kDeviceLost);
    CHECK_FALSE(told.ended);
  }
  CHECK(bench.kernel.open_files == 0);
}

TEST_CASE("V4L2: a buffer that cannot be given back ends the stream") {
  V4l2Bench bench;
  bench.start_with_clock();
  bench.kernel.frame(evt3_event(100, 1, 5));
  bench.kernel.errors[VIDIOC_QBUF] = {ENODEV};
  bench.poll();
  CHECK(bench.source->counters().lost == 1);
  CHECK(bench.kernel.mapped == 0);
}

TEST_CASE("V4L2: a silent stream is started anew after the time that the settings say") {
  V4l2CameraSettings settings = V4l2Bench::small();
  settings.silence_ms = GENERATE(250, 0);
  V4l2Bench bench(settings);
  bench.start_with_clock();
  for (int i = 0; i < 25; ++i) bench.poll(10'000);
  CHECK(bench.source->counters().lost == 0);
  bench.poll(10'000);
  CHECK(bench.source->counters().lost == (settings.silence_ms == 0 ? 0 : 1));
  if (settings.silence_ms != 0) CHECK(bench.source->counters().last_error.value() == ETIMEDOUT);
}

TEST_CASE("V4L2: one poll takes what the driver has room for, however fast it fills") {
  V4l2Bench bench;
  bench.start_with_clock();
  for (std::uint32_t i = 0; i < 10; ++i) bench.kernel.frame(evt3_event(100 + i, 1, 5));
  bench.poll();
  CHECK(bench.events().size() == 4);
  bench.poll();
  bench.poll();
  CHECK(bench.events().size() == 6);
  CHECK(bench.source->counters().lost_buffers == 0);
}

TEST_CASE("V4L2: a full ring drops events, never buffers") {
  V4l2Bench bench;
  bench.start_with_clock();
  using namespace evt_words::evt3;
  evt_words::Bytes row = evt3_event(100, 0, 5);
  for (int i = 0; i < 250; ++i) row = row + stream({base_x(1, 0), vect12(0xfff), vect12(0xfff), vect8(0xff)});
  bench.kernel.frame(row);
  bench.poll();
  CHECK(bench.source->counters().samples.pushed == 8001);
  CHECK(bench.events().size() == 4096);
  CHECK(bench.kernel.queued.size() == 4);
}

TEST_CASE("V4L2: time that leaps back is a new beginning for the clock, counted") {
  V4l2Bench bench;
  bench.start_with_clock();
  bench.kernel.frame(evt3_event(4'000'000, 1, 5));
  bench.poll();
  CHECK(bench.events().size() == 1);
  evt_words::Bytes back;
  for (int i = 0; i < 16; ++i) back = back + evt3_event(8192, 2, 5);
  bench.kernel.frame(back);
  bench.poll();
  CHECK(bench.source->counters().samples.clock_restarts == 1);
  CHECK(bench.source->counters().samples.unmapped >= 1);
  bench.events();
  bench.pass(1000);
  bench.kernel.frame(evt3_event(9192, 3, 5));
  bench.poll();
  const std::vector<Event> events = bench.events();
  REQUIRE(events.size() == 1);
  CHECK(events[0].t_us == bench.kernel.time.now_us());
}

TEST_CASE("V4L2: poll before start is a mistake that is told") {
  V4l2Bench bench;
  CHECK(bench.poll().status.code() == StatusCode::kBadState);
  bench.source->stop();
  bench.source->stop();
}
