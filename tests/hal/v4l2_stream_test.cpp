// What the buffers of a V4L2 stream can do: be full of old bytes, lack their end, lie, vanish, wait.
#include "hal/v4l2_bench.hpp"

using namespace egofocus;
using evt_words::Bytes;
using Columns = std::vector<int>;

namespace {

constexpr std::uint32_t kMonotonic = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;

Bytes filled_up(Bytes bytes, const Bytes& with, std::size_t size = 8192) {
  while (bytes.size() < size) bytes.insert(bytes.end(), with.begin(), with.end());
  bytes.resize(size);
  return bytes;
}

}  // namespace

TEST_CASE("V4L2: events come out on the host's clock, and words go on in the next buffer") {
  V4l2Bench bench;
  bench.start_with_clock();
  const Bytes all = evt3_event(1000, 7, 5) + evt3_event(1500, 8, 5);
  bench.pass(2000);
  bench.kernel.frame(Bytes(all.begin(), all.begin() + 13));  // in the middle of a word
  bench.pass(1);
  bench.kernel.frame(Bytes(all.begin() + 13, all.end()));
  const Delivery told = bench.poll();
  CHECK(told.status.ok());
  const std::vector<Event> events = bench.events();
  REQUIRE(events.size() == 2);
  CHECK(events[0].x == 7);
  CHECK(events[0].y == 5);
  CHECK(events[0].t_us == bench.base_us + 1000);
  CHECK(events[1].x == 8);
  CHECK(events[1].t_us == bench.base_us + 1500);
  CHECK(told.watermark_us == bench.base_us + 1499);
  const V4l2CameraCounters counters = bench.source->counters();
  CHECK(counters.buffers == 3);
  CHECK(counters.decoded == 3);
  CHECK(counters.samples.pushed == 2);
  CHECK(counters.without_stamp == 0);
  CHECK(bench.kernel.queued.size() == 4);
}

TEST_CASE("V4L2: with device_time events keep the sensor's time, from the first one on") {
  V4l2CameraSettings settings = V4l2Bench::small();
  settings.device_time = true;
  V4l2Bench bench(settings);
  bench.start();
  bench.pass(700'000);
  bench.kernel.frame(evt3_event(1000, 7, 5));
  CHECK(bench.poll().watermark_us == 999);
  const std::vector<Event> events = bench.events();
  REQUIRE(events.size() == 1);
  CHECK(events[0].t_us == 1000);
  CHECK(bench.source->counters().samples.unmapped == 0);
}

TEST_CASE("V4L2: stale bytes behind the end-of-frame marker are never decoded") {
  V4l2Bench bench;
  bench.disguise();
  bench.start_with_clock();
  const Bytes stale = evt3_event(3, 999, 9);
  for (std::uint32_t i = 1; i <= 50; ++i) {
    bench.pass(1000);
    bench.kernel.frame(filled_up(evt3_event(i * 1000, i, 5) + marker(), stale));
    bench.poll();
  }
  Columns expected;
  for (int i = 1; i <= 50; ++i) expected.push_back(i);
  CHECK(bench.columns() == expected);
  CHECK(bench.source->counters().bytes == 4 + 50 * 8);
  CHECK(bench.source->counters().unmarked_refused == 0);
}

TEST_CASE("V4L2: a marker beyond the first stretch of copying is found, and so is one at the very end") {
  V4l2Bench bench;
  bench.disguise();
  bench.start_with_clock();
  for (const std::size_t at : {std::size_t{4096}, std::size_t{4094}, std::size_t{8190}}) {
    Bytes bytes = evt3_event(static_cast<std::uint32_t>(at), 1, 5);
    const Bytes one = evt_words::evt3::stream({evt_words::evt3::addr_x(1, 2)});
    while (bytes.size() < at) bytes.insert(bytes.end(), one.begin(), one.end());
    bench.pass(5000);
    bench.kernel.frame(filled_up(bytes + evt_words::evt3::stream({0xE019}),
                                 evt_words::evt3::stream({evt_words::evt3::addr_x(1, 999)})));
    bench.poll();
    const Columns columns = bench.columns();
    CHECK(columns.size() == at / 2 - 3);
    CHECK(std::find(columns.begin(), columns.end(), 999) == columns.end());
  }
}

TEST_CASE("V4L2: a buffer without marker is refused, and the decoder waits for the next TIME_HIGH") {
  V4l2Bench bench;
  bench.disguise();
  bench.start_with_clock();
  bench.pass(1000);
  bench.kernel.frame(filled_up({}, evt3_event(3, 999, 9)));
  bench.kernel.frame(evt_words::evt3::stream({evt_words::evt3::addr_x(1, 998)}) + evt3_event(900, 4, 5) +
                     marker());
  bench.poll();
  CHECK(bench.columns() == Columns{4});
  const V4l2CameraCounters counters = bench.source->counters();
  CHECK(counters.unmarked_refused == 1);
  CHECK(counters.unmarked_decoded == 0);
  CHECK(counters.evt[EvtViolation::kBeforeTimeHigh] == 1);
  CHECK(counters.evt.dropped_events == 1);
  CHECK(counters.buffers == counters.decoded + counters.unmarked_refused);
}

TEST_CASE("V4L2: a buffer without marker is decoded where the settings say so") {
  V4l2CameraSettings settings = V4l2Bench::small();
  settings.decode_unmarked = true;
  V4l2Bench bench(settings);
  bench.disguise();
  bench.start_with_clock();
  bench.pass(1000);
  bench.kernel.frame(evt3_event(900, 4, 5));
  bench.poll();
  CHECK(bench.columns() == Columns{4});
  CHECK(bench.source->counters().unmarked_decoded == 1);
  CHECK(bench.source->counters().unmarked_refused == 0);
}

TEST_CASE("V4L2: where the receiver tells the size, a word that looks like the marker is none") {
  V4l2Bench bench;
  bench.start_with_clock();
  bench.pass(1000);
  bench.kernel.frame(evt3_event(500, 4, 5) + marker() + evt3_event(600, 6, 5));
  auto& second = bench.kernel.frame(filled_up(evt3_event(700, 8, 5), evt3_event(3, 999, 9)));
  second.used = 8;
  bench.poll();
  CHECK(bench.columns() == Columns{4, 6, 8});
}

TEST_CASE("V4L2: both word orders of EVT2.1 end at the marker, and no mask of pixels is taken for it") {
  using namespace evt_words::evt21;
  const bool is_legacy = GENERATE(false, true);
  CAPTURE(is_legacy);
  V4l2Bench bench;
  bench.disguise();
  auto& encoding = bench.kernel.controls["/dev/v4l-subdev2"][0];
  encoding.menu = {"EVT2", "EVT21", "EVT3", "EVT21ME"};
  encoding.value = is_legacy ? 3 : 1;
  bench.start();
  const Word end = {0xE019E019, 0xE019E019};
  bench.kernel.frame(stream({time_high(0), end}, is_legacy));
  bench.poll();
  bench.pass(1000);
  // The mask alone matches the marker's pattern.
  const std::uint32_t mask = 0xE0000019;
  bench.kernel.frame(stream({time_high(5), cd(1, 3, 32, 5, mask), end, cd(1, 3, 640, 9, 0xffff)}, is_legacy));
  const std::int64_t zero_us = bench.kernel.time.now_us() - 1000;
  CHECK(bench.poll().watermark_us == zero_us + 5 * 64 + 3 - 1);
  CHECK(bench.columns() == Columns{32, 35, 36, 61, 62, 63});
  CHECK(bench.source->counters().unmarked_refused == 0);
}

TEST_CASE("V4L2: EVT2 ends at the marker") {
  using namespace evt_words::evt2;
  V4l2Bench bench;
  bench.disguise();
  bench.kernel.controls["/dev/v4l-subdev2"][0].value = 0;
  bench.start();
  bench.kernel.frame(stream({time_high(0), 0xE019E019}));
  bench.pass(1000);
  bench.kernel.frame(stream({time_high(1), cd(1, 3, 33, 5), other(0x14), 0xE019E019, cd(1, 3, 999, 9)}));
  CHECK(bench.poll().watermark_us == bench.kernel.time.now_us() - 1000 + 64 + 3 - 1);
  const std::vector<Event> events = bench.events();
  REQUIRE(events.size() == 1);
  CHECK(events[0].x == 33);
  CHECK(events[0].t_us == bench.kernel.time.now_us() - 1000 + 64 + 3);
}

TEST_CASE("V4L2: a buffer that the driver marks as damaged is dropped, with what hangs on it") {
  V4l2Bench bench;
  bench.start_with_clock();
  bench.pass(1000);
  bench.kernel.frame(evt3_event(100, 1, 5));
  bench.kernel.frame(evt3_event(200, 2, 6)).flags |= V4L2_BUF_FLAG_ERROR;
  bench.kernel.frame(evt_words::evt3::stream({evt_words::evt3::addr_x(1, 998)}) + evt3_event(300, 3, 5));
  bench.poll();
  CHECK(bench.columns() == Columns{1, 3});
  CHECK(bench.source->counters().damaged == 1);
  CHECK(bench.source->counters().evt.dropped_events == 1);
  CHECK(bench.kernel.queued.size() == 4);
}

TEST_CASE("V4L2: gaps of the sequence are counted, and half a word before one is not glued to what follows") {
  V4l2Bench bench;
  bench.start_with_clock();
  bench.pass(1000);
  Bytes torn = evt3_event(100, 1, 5);
  torn.push_back(std::byte{0x42});
  bench.kernel.frame(torn);
  bench.kernel.sequence += 3;
  bench.kernel.frame(evt3_event(300, 3, 5));
  bench.poll();
  CHECK(bench.columns() == Columns{1, 3});
  CHECK(bench.source->counters().lost_buffers == 3);
  CHECK(bench.source->counters().evt[EvtViolation::kUnknownWord] == 1);
}

TEST_CASE("V4L2: a sequence that wraps, or never counts, is no gap") {
  V4l2Bench bench;
  bench.kernel.sequence = UINT32_MAX - 1;
  bench.start_with_clock();
  bench.kernel.frame(evt3_event(100, 1, 5));
  bench.kernel.frame(evt3_event(200, 2, 5));
  bench.poll();
  bench.kernel.frame(evt3_event(300, 3, 5)).sequence = 0;
  bench.poll();
  CHECK(bench.columns() == Columns{1, 2, 3});
  CHECK(bench.source->counters().lost_buffers == 0);
}

TEST_CASE("V4L2: lies about sizes never leave the buffer") {
  V4l2Bench bench;
  bench.start_with_clock();
  bench.kernel.frame(evt3_event(100, 1, 5)).used = 8193;
  bench.kernel.frame(evt3_event(200, 2, 5)).used = 0;
  bench.poll();
  CHECK(bench.columns().empty());
  CHECK(bench.source->counters().wrong == 1);
  CHECK(bench.source->counters().empty == 1);
  bench.kernel.frame(evt3_event(300, 3, 5)).index = 77;
  bench.poll();
  CHECK(bench.source->counters().lost == 1);
  CHECK(bench.source->counters().last_error.value() == EIO);
}

TEST_CASE("V4L2: planes with an offset of their data") {
  V4l2Bench bench;
  bench.kernel.caps = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  bench.start_with_clock();
  bench.kernel.frame(Bytes(6, std::byte{0xff}) + evt3_event(100, 1, 5)).data_offset = 6;
  bench.kernel.frame(evt3_event(200, 2, 5)).data_offset = 9;  // beyond what is used
  bench.poll();
  CHECK(bench.columns() == Columns{1});
  CHECK(bench.source->counters().wrong == 1);
}

TEST_CASE("V4L2: time stamps that are none of the monotonic clock at the end of the frame are not used") {
  V4l2Bench bench;
  bench.start_with_clock();
  const std::int64_t now_us = bench.kernel.time.now_us();
  bench.kernel.frame(evt3_event(10, 1, 5)).flags = V4L2_BUF_FLAG_TIMESTAMP_COPY;
  bench.kernel.frame(evt3_event(20, 2, 5)).flags = kMonotonic | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  bench.kernel.frame(evt3_event(30, 3, 5)).stamp_us = now_us + 1'000'000;
  bench.kernel.frame(evt3_event(40, 4, 5)).stamp_us = now_us - 20'000'000;
  bench.poll();
  CHECK(bench.source->counters().without_stamp == 4);
  CHECK(bench.events().size() == 4);
}

TEST_CASE("V4L2: the kernel's stamp is what the map is made of, not the time of taking") {
  V4l2Bench bench;
  bench.start_with_clock();
  for (std::uint32_t i = 1; i <= 200; ++i) {  // taken 7 ms late each time
    bench.pass(2000);
    bench.kernel.frame(evt3_event(i * 2000, 1, 5)).stamp_us = bench.base_us + i * 2000;
    if (i == 1) bench.pass(7000);
    bench.poll();
  }
  const std::vector<Event> events = bench.events();
  REQUIRE(events.size() == 200);
  for (std::size_t i = 0; i < events.size(); ++i) {
    CHECK(events[i].t_us == bench.base_us + 2000 * static_cast<std::int64_t>(i + 1));
  }
}
