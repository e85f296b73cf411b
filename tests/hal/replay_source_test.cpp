#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "core/inlets.hpp"
#include "evt_printing.hpp"
#include "hal/evt3_encoder.hpp"
#include "hal/replay_source.hpp"

using namespace egofocus;

namespace {

// Rings of a few samples each, and what a reader took out of them.
struct Reader {
  explicit Reader(std::size_t capacity)
      : event_slots(capacity), imu_slots(capacity), odometry_slots(capacity), pose_slots(capacity) {}

  template <typename Sample>
  static void take_all(SpscRing<Sample>& ring, std::vector<Sample>& out) {
    for (auto ready = ring.peek(SIZE_MAX >> 1); !ready.empty(); ready = ring.peek(SIZE_MAX >> 1)) {
      out.insert(out.end(), ready.begin(), ready.end());
      ring.release(ready.size());
    }
  }
  void take() {
    take_all(rings.events, events);
    take_all(rings.imu, imu);
    take_all(rings.odometry, odometry);
    take_all(rings.poses, poses);
  }

  std::vector<Event> event_slots;
  std::vector<ImuSample> imu_slots;
  std::vector<OdometrySample> odometry_slots;
  std::vector<PoseSample> pose_slots;
  Inlets::Rings rings{SpscRing<Event>(event_slots), SpscRing<ImuSample>(imu_slots),
                      SpscRing<OdometrySample>(odometry_slots), SpscRing<PoseSample>(pose_slots)};
  Inlets inlets{rings};
  std::vector<Event> events;
  std::vector<ImuSample> imu;
  std::vector<OdometrySample> odometry;
  std::vector<PoseSample> poses;
};

std::vector<Event> some_events() {
  std::vector<Event> events;
  for (int i = 0; i < 1000; ++i) {
    events.push_back({i * 100, static_cast<std::uint16_t>(i % 64), static_cast<std::uint16_t>(i % 48), 1});
  }
  return events;
}

std::vector<std::byte> raw_file(const std::vector<Event>& events) {
  RawHeader header;
  header.size = {64, 48};
  std::vector<std::byte> bytes(kMaxWrittenRawHeaderBytes + events.size() * 16);
  std::size_t size = write_raw_header(header, bytes);
  Evt3Encoder encoder;
  size += encoder.encode(events, std::span(bytes).subspan(size)).produced;
  bytes.resize(size);
  return bytes;
}

constexpr const char* kPoses =
    "0.010 1 0 0 0 0 0 1\n# comment\n0.020 2 0 0 0 0 0 1\n0.030 3 0 0 0 0 0 1\n0.040 4 0 0 0 0 0 1";

// Message 100: wheel speed, 0.01 m/s. Messages 101 and 102: yaw and roll rate, one sample in two frames.
constexpr const char* kDbc =
    "BO_ 100 SPEED: 2 E\n SG_ v : 0|16@1+ (0.01,0) [0|0] \"\" X\n\n"
    "BO_ 101 YAW: 2 E\n SG_ z : 0|16@1- (0.001,0) [0|0] \"\" X\n\n"
    "BO_ 102 ROLL: 2 E\n SG_ x : 0|16@1- (0.001,0) [0|0] \"\" X\n";
constexpr const char* kCanLog =
    "(0.010000) can0 064#6400\n"   // 1 m/s
    "(0.019000) can0 065#E803\n"   // yaw 1 rad/s at 19 ms
    "(0.020000) can0 064#C800\n"   // 2 m/s
    "(0.021000) can0 066#D007\n"   // roll 2 rad/s: completes the sample of 19 ms
    "(0.035000) can0 064#2C01\n";  // 3 m/s

CanSignalRole role_of(const char* message, const char* signal, CanRole role) {
  CanSignalRole result;
  std::strcpy(result.message, message);
  std::strcpy(result.signal, signal);
  result.role = role;
  return result;
}

struct Can {
  Can() {
    auto dbc = std::make_unique<Dbc>();
    REQUIRE(read_dbc(kDbc, {}, *dbc).ok());
    config.signals[0] = role_of("SPEED", "v", CanRole::kWheelSpeed);
    config.signals[1] = role_of("YAW", "z", CanRole::kGyroZ);
    config.signals[2] = role_of("ROLL", "x", CanRole::kGyroX);
    config.signal_count = 3;
    REQUIRE(decoder->configure(config, *dbc).ok());
  }
  CanMotionConfig config;
  std::unique_ptr<CanMotionDecoder> decoder = std::make_unique<CanMotionDecoder>();
};

std::span<const std::byte> bytes_of(const char* text) {
  return std::as_bytes(std::span(text, std::strlen(text)));
}

template <typename Samples>
std::vector<std::int64_t> times(const Samples& samples) {
  std::vector<std::int64_t> result;
  for (const auto& sample : samples) result.push_back(sample.t_us);
  return result;
}

using Times = std::vector<std::int64_t>;

}  // namespace

TEST_CASE("replay: an empty recording ends at once") {
  ReplaySource replay({});
  REQUIRE(replay.start().ok());
  Reader reader(2);
  const Delivery delivery = replay.poll(reader.inlets, 50);
  CHECK(delivery.ended);
  CHECK(delivery.watermark_us == 50);
}

TEST_CASE("replay: each poll brings exactly the samples up to its time") {
  const std::vector<Event> events = some_events();
  const std::vector<std::byte> file = raw_file(events);
  Can can;
  ReplaySource replay({.events_raw = file,
                       .can_log = bytes_of(kCanLog),
                       .poses_txt = bytes_of(kPoses),
                       .can_motion = can.decoder.get(),
                       .can_lag_us = can_lag_us(can.config)});
  const Source source = replay.source();
  REQUIRE(source.start(source.self).ok());
  Reader reader(1024);
  Delivery delivery = source.poll(source.self, reader.inlets, 20'000, 0);
  reader.take();
  CHECK(delivery.watermark_us == 20'000);
  CHECK_FALSE(delivery.ended);
  CHECK(reader.events.size() == 201);
  CHECK(times(reader.poses) == Times{10'000, 20'000});
  CHECK(times(reader.odometry) == Times{10'000, 20'000});
  CHECK(times(reader.imu) == Times{19'000});  // its second frame came after the poll's time
  CHECK(reader.imu.at(0).gyro_rad_s[0] == 2.0);

  delivery = source.poll(source.self, reader.inlets, 99'000, 0);
  CHECK_FALSE(delivery.ended);
  delivery = source.poll(source.self, reader.inlets, 200'000, 0);
  reader.take();
  CHECK(delivery.ended);
  CHECK(delivery.watermark_us == 200'000);
  CHECK(reader.events == events);
  CHECK(times(reader.poses) == Times{10'000, 20'000, 30'000, 40'000});
  CHECK(times(reader.odometry) == Times{10'000, 20'000, 35'000});
  const ReplayCounters counters = replay.counters();
  CHECK(counters.events.events == 1000);
  CHECK(counters.events_pushed == 1000);
  CHECK(counters.poses_pushed == 4);
  CHECK(counters.odometry_pushed == 3);
  CHECK(counters.imu_pushed == 1);
  CHECK(counters.can_log.frames == 5);
  CHECK(counters.can_motion.frames_used == 5);
  CHECK(counters.poses.blank == 1);
  source.stop(source.self);
}

TEST_CASE("replay: full rings delay, never drop, and hold the watermark back") {
  const std::vector<Event> events = some_events();
  const std::vector<std::byte> file = raw_file(events);
  Can can;
  ReplaySource replay({.events_raw = file,
                       .can_log = bytes_of(kCanLog),
                       .poses_txt = bytes_of(kPoses),
                       .can_motion = can.decoder.get(),
                       .can_lag_us = can_lag_us(can.config)});
  REQUIRE(replay.start().ok());
  Reader reader(2);
  Delivery delivery;
  std::int64_t last = INT64_MIN;
  int polls = 0;
  for (; !delivery.ended && polls < 2000; ++polls) {
    delivery = replay.poll(reader.inlets, 1'000'000);
    reader.take();
    CHECK(delivery.watermark_us >= last);
    last = delivery.watermark_us;
    if (!delivery.ended && reader.events.size() < events.size()) {
      CHECK(last < events[reader.events.size()].t_us);  // what is not out yet lies beyond the watermark
    }
  }
  CHECK(delivery.ended);
  CHECK(polls >= 500);
  CHECK(reader.events == events);
  CHECK(reader.poses.size() == 4);
  CHECK(reader.odometry.size() == 3);
  CHECK(reader.imu.size() == 1);
  CHECK(reader.rings.events.dropped() == 0);
  CHECK(reader.rings.odometry.dropped() == 0);
}

TEST_CASE("replay: the offset carries device time to the recording's time") {
  const std::vector<std::byte> file = raw_file({{5, 1, 2, 1}});
  ReplaySource replay({.events_raw = file, .events_offset_us = 1'000'000});
  REQUIRE(replay.start().ok());
  Reader reader(4);
  CHECK_FALSE(replay.poll(reader.inlets, 1'000'004).ended);
  CHECK(replay.poll(reader.inlets, 1'000'005).ended);
  reader.take();
  CHECK(times(reader.events) == Times{1'000'005});
}

TEST_CASE("replay: start again begins again") {
  const std::vector<std::byte> file = raw_file(some_events());
  ReplaySource replay({.events_raw = file});
  Reader reader(2048);
  for (int i = 0; i < 2; ++i) {
    REQUIRE(replay.start().ok());
    CHECK(replay.poll(reader.inlets, 1'000'000).ended);
    CHECK(replay.counters().events_pushed == 1000);
    reader.take();
  }
  CHECK(reader.events.size() == 2000);
}

TEST_CASE("replay: samples far beyond the CAN lag cannot block it") {
  std::string log;
  for (int i = 0; i < 500; ++i) log += "(9.000000) can0 064#6400\n";
  log += "(0.500000) can0 064#6400\n";
  Can can;
  ReplaySource replay(
      {.can_log = bytes_of(log.c_str()), .can_motion = can.decoder.get(), .can_lag_us = 10'000'000});
  REQUIRE(replay.start().ok());
  Reader reader(8);
  Delivery delivery;
  for (int polls = 0; polls < 1000 && reader.odometry.size() < 501; ++polls) {
    delivery = replay.poll(reader.inlets, polls < 500 ? 1000 : 10'000'000);
    reader.take();
  }
  CHECK(reader.odometry.size() == 501);
}

TEST_CASE("replay: faults of the set-up are told by start") {
  const char* junk = "no header";
  ReplaySource no_header({.events_raw = bytes_of(junk)});
  CHECK(no_header.start().code() == StatusCode::kBadHeader);
  ReplaySource no_decoder({.can_log = bytes_of(kCanLog)});
  CHECK(no_decoder.start().code() == StatusCode::kBadState);
}
