#include <catch2/catch.hpp>

#include "evt_printing.hpp"
#include "hal/inivation_decoder.hpp"
#include "inivation_stream.hpp"

using namespace egofocus;
using namespace inivation;
using Events = std::vector<Event>;

namespace {

constexpr InivationLayout kDavis346{.format = InivationFormat::kDavis, .sent = {346, 260}};
constexpr InivationLayout kDvx{.format = InivationFormat::kDvxplorer, .sent = {640, 480}};

struct Outcome {
  Events events;
  std::vector<ImuSample> imu;
  InivationCounters counters;
  std::uint64_t operator[](InivationViolation kind) const { return counters[kind]; }
};

Outcome run(const InivationLayout& layout, const Bytes& bytes, std::size_t cut = SIZE_MAX,
            std::size_t room = 64) {
  InivationDecoder decoder(layout);
  Outcome outcome;
  Events events(room);
  std::vector<ImuSample> imu(room);
  std::span<const std::byte> left = bytes;
  for (;;) {
    const InivationDecoded done =
        decoder.feed(left.first(left.size() < cut ? left.size() : cut), events, imu);
    outcome.events.insert(outcome.events.end(), events.begin(),
                          events.begin() + static_cast<std::ptrdiff_t>(done.events));
    outcome.imu.insert(outcome.imu.end(), imu.begin(), imu.begin() + static_cast<std::ptrdiff_t>(done.imu));
    left = left.subspan(done.consumed);
    if (left.empty() && done.events < room && done.imu < room) break;
  }
  outcome.counters = decoder.counters();
  return outcome;
}

}  // namespace

TEST_CASE("DAVIS: rows, columns and time in hand-made bytes") {
  // Time 0x0123, Y 0x0AB, X 0x102 OFF, X 0x103 ON, wrap by 2, time 0x0001, X 0x000 ON.
  const unsigned char raw[] = {0x23, 0x81, 0xAB, 0x10, 0x02, 0x21, 0x03,
                               0x31, 0x02, 0x70, 0x01, 0x80, 0x00, 0x30};
  const auto* first = reinterpret_cast<const std::byte*>(raw);
  const Outcome outcome = run(kDavis346, Bytes(first, first + sizeof raw));
  CHECK(outcome.events == Events{{0x123, 0x102, 0xAB, 0}, {0x123, 0x103, 0xAB, 1}, {0x10001, 0, 0xAB, 1}});
  CHECK(outcome.counters.dropped_events == 0);
}

TEST_CASE("DAVIS: a wrap alone moves time to its multiple of 2^15 us") {
  const Outcome outcome =
      run(kDavis346, stream({time_stamp(5), row(1), wrap(1), column(1, 2), wrap(0xfff), column(1, 3)}));
  CHECK(outcome.events == Events{{0x8000, 2, 1, 1}, {0x8000LL * 0x1000, 3, 1, 1}});
}

TEST_CASE("DAVIS: events before any time, row or inside no array are dropped and counted") {
  const Outcome outcome = run(kDavis346, stream({row(1), column(1, 1), time_stamp(1), row(260), column(1, 1),
                                                 row(259), column(0, 346), column(0, 345)}));
  CHECK(outcome.events == Events{{1, 345, 259, 0}});
  CHECK(outcome[InivationViolation::kBeforeTime] == 1);
  CHECK(outcome[InivationViolation::kOutOfRange] == 2);
  CHECK(outcome.counters.dropped_events == 3);
  CHECK(run(kDavis346, stream({time_stamp(1), column(1, 1)}))[InivationViolation::kOutOfRange] == 1);
}

TEST_CASE("DAVIS: a time stamp that steps back takes its events with it, the next good one ends that") {
  const Outcome outcome = run(kDavis346, stream({time_stamp(9), row(0), column(1, 1), time_stamp(8),
                                                 column(1, 2), column(1, 3), time_stamp(9), column(1, 4)}));
  CHECK(outcome.events == Events{{9, 1, 0, 1}, {9, 4, 0, 1}});
  CHECK(outcome[InivationViolation::kTimeBackward] == 1);
  CHECK(outcome.counters.dropped_events == 2);
}

TEST_CASE("DAVIS: a time reset begins at zero and is counted") {
  const Outcome outcome =
      run(kDavis346,
          stream({wrap(7), row(2), column(1, 1), time_reset(), column(1, 2), time_stamp(4), column(1, 3)}));
  CHECK(outcome.events == Events{{7 * 0x8000, 1, 2, 1}, {0, 2, 2, 1}, {4, 3, 2, 1}});
  CHECK(outcome.counters.time_resets == 1);
}

TEST_CASE("DAVIS: time beyond 2^60 us is refused") {
  InivationTime time;
  InivationCounters counters;
  for (std::uint64_t i = 0; i < 100; ++i) time.wrap(0xffffffff, counters);  // 2^47 us each
  CHECK(time.us() <= std::int64_t{1} << 60);
  CHECK(counters[InivationViolation::kTimeLeap] == 0);
  for (std::uint64_t i = 0; i < 10000; ++i) time.wrap(0xffffffff, counters);
  CHECK(time.us() <= std::int64_t{1} << 60);
  CHECK(counters[InivationViolation::kTimeLeap] > 1000);
}

TEST_CASE("DAVIS: frames are skipped and counted, triggers too, other codes are unknown") {
  const Outcome outcome =
      run(kDavis346, stream({time_stamp(1), special(8),  special(11), frame_sample(1023), frame_sample(0),
                             special(13),   special(10), special(14), special(15),        0x5101,
                             0x5202,        0x6003,      special(2),  special(3),         special(4),
                             special(0),    special(16), special(17), special(6),         special(18),
                             0x5400}));
  CHECK(outcome.counters.frame_words == 11);
  CHECK(outcome.counters.triggers == 3);
  CHECK(outcome[InivationViolation::kUnknownWord] == 3);
}

TEST_CASE("DAVIS: a swapped array is checked as sent and given out swapped") {
  constexpr InivationLayout kSwapped{.format = InivationFormat::kDavis, .sent = {346, 260}, .swaps_xy = true};
  const Outcome outcome = run(kSwapped, stream({time_stamp(1), row(259), column(1, 345), column(1, 346)}));
  CHECK(outcome.events == Events{{1, 259, 345, 1}});
  CHECK(kSwapped.size().width_px == 260);
  CHECK(kSwapped.size().height_px == 346);
}

TEST_CASE("DAVIS: IMU bytes become SI, axis by axis") {
  Bytes bytes = stream({time_stamp(100)});
  // All parts run (0xE0), accelerometer +-4 g (1), gyro +-500 deg/s (1).
  append_imu(bytes, 0xE0 + (1 << 2) + 1, {8192, -8192, 4096, 123, 32767, -32768, 66});
  append(bytes, time_stamp(101), 2);
  const Outcome outcome = run(kDavis346, bytes);
  REQUIRE(outcome.imu.size() == 1);
  const ImuSample& sample = outcome.imu[0];
  CHECK(sample.t_us == 100);
  CHECK(sample.has_accel);
  CHECK(sample.has_gyro);
  // 8192 LSB/g and 65.536 LSB per deg/s.
  CHECK(sample.accel_m_s2[0] == Approx(9.80665));
  CHECK(sample.accel_m_s2[1] == Approx(-9.80665));
  CHECK(sample.accel_m_s2[2] == Approx(9.80665 / 2));
  CHECK(sample.gyro_rad_s[0] == Approx(32767 / 65.536 * 3.14159265358979 / 180));
  CHECK(sample.gyro_rad_s[1] == Approx(-500 * 3.14159265358979 / 180));
  CHECK(sample.gyro_rad_s[2] == Approx(66 / 65.536 * 3.14159265358979 / 180));
  CHECK(outcome.counters.imu_samples == 1);
}

TEST_CASE("DAVIS: parts of the IMU that do not run are absent from the stream") {
  const int accel[] = {100, 200, 300};
  SECTION("gyro alone") {
    Bytes bytes = stream({time_stamp(1)});
    append_imu(bytes, 0x40, {1000, 2000, 3000});
    const Outcome outcome = run(kDavis346, bytes);
    REQUIRE(outcome.imu.size() == 1);
    CHECK_FALSE(outcome.imu[0].has_accel);
    CHECK(outcome.imu[0].gyro_rad_s[2] == Approx(3000 / 131.072 * 3.14159265358979 / 180));
    CHECK(outcome.imu[0].accel_m_s2[0] == 0);
  }
  SECTION("accelerometer and gyro without temperature") {
    Bytes bytes = stream({time_stamp(1)});
    append_imu(bytes, 0xC0, {accel[0], accel[1], accel[2], 1, 2, 3});
    const Outcome outcome = run(kDavis346, bytes);
    REQUIRE(outcome.imu.size() == 1);
    CHECK(outcome.imu[0].accel_m_s2[2] == Approx(300 / 16384.0 * 9.80665));
    CHECK(outcome.imu[0].gyro_rad_s[0] == Approx(1 / 131.072 * 3.14159265358979 / 180));
  }
  SECTION("accelerometer and temperature") {
    Bytes bytes = stream({time_stamp(1)});
    append_imu(bytes, 0xA0, {accel[0], accel[1], accel[2], 77});
    const Outcome outcome = run(kDavis346, bytes);
    REQUIRE(outcome.imu.size() == 1);
    CHECK_FALSE(outcome.imu[0].has_gyro);
  }
}

TEST_CASE("DAVIS: incomplete, overfull and unannounced IMU samples are dropped and counted") {
  Bytes bytes = stream({time_stamp(1), imu_byte(1), imu_end()});  // the end of a sample that began before us
  append_imu(bytes, 0xE0, {1, 2, 3, 4, 5, 6});
  append_imu(bytes, 0xE0, {1, 2, 3, 4, 5, 6, 7, 8});
  append_imu(bytes, 0x00, {});
  const Outcome outcome = run(kDavis346, bytes);
  CHECK(outcome.imu.empty());
  CHECK(outcome[InivationViolation::kImuIncomplete] == 3);
  CHECK(run(kDavis346, stream({imu_begin(), imu_byte(1), imu_end()}))[InivationViolation::kImuIncomplete] ==
        1);
}

TEST_CASE("IMU axes that the camera says are flipped change their sign") {
  Bytes bytes = stream({time_stamp(1)});
  append_imu(bytes, 0xE0, {16384, 16384, 16384, 0, 131, 131, 131});
  InivationLayout layout = kDavis346;
  layout.imu_flips = 5;  // x and z
  const Outcome outcome = run(layout, bytes);
  REQUIRE(outcome.imu.size() == 1);
  CHECK(outcome.imu[0].accel_m_s2[0] == Approx(-9.80665));
  CHECK(outcome.imu[0].accel_m_s2[1] == Approx(9.80665));
  CHECK(outcome.imu[0].accel_m_s2[2] == Approx(-9.80665));
  CHECK(outcome.imu[0].gyro_rad_s[0] < 0);
}

TEST_CASE("DVXplorer: masks of eight rows around one column") {
  // Column 300, group 1 at row 8 * 10, group 2 three groups below it, then three above.
  const Outcome outcome =
      run(kDvx, stream({time_stamp(7), dvx_column(300), dvx_rows(10, 3, false), dvx_group(1, 1, 0x81),
                        dvx_group(2, 0, 0x02), dvx_rows(10, 3, true), dvx_group(2, 1, 0x01)}));
  CHECK(outcome.events == Events{{7, 300, 80, 1}, {7, 300, 87, 1}, {7, 300, 105, 0}, {7, 300, 56, 1}});
}

TEST_CASE("DVXplorer: columns and rows outside the array are dropped by pixel") {
  const Outcome outcome =
      run(kDvx, stream({time_stamp(7), dvx_column(640), dvx_rows(0, 0, false), dvx_group(1, 1, 0x03),
                        dvx_column(639), dvx_rows(60, 0, false), dvx_group(1, 1, 0xff), dvx_rows(2, 3, true),
                        dvx_group(2, 1, 0x01), dvx_rows(59, 0, false), dvx_group(1, 1, 0x80)}));
  CHECK(outcome.events == Events{{7, 639, 479, 1}});
  CHECK(outcome.counters.dropped_events == 2 + 8 + 1);
  constexpr InivationLayout kOdd{.format = InivationFormat::kDvxplorer, .sent = {640, 4}};
  const Outcome cut =
      run(kOdd, stream({time_stamp(7), dvx_column(1), dvx_rows(0, 0, false), dvx_group(1, 1, 0xff)}));
  CHECK(cut.events.size() == 4);
  CHECK(cut.counters.dropped_events == 4);
}

TEST_CASE("DVXplorer: its IMU is turned, its gyro ranges count downwards") {
  Bytes bytes = stream({time_stamp(1)});
  // Accelerometer code 1 (+-4 g) in bits 4..3, gyro code 2 (+-500 deg/s) in bits 2..0.
  append_imu(bytes, 0xE0 + (1 << 3) + 2, {8192, -8192, 0, 0, 3277, 6554, 0});
  const Outcome outcome = run(kDvx, bytes);
  REQUIRE(outcome.imu.size() == 1);
  CHECK(outcome.imu[0].accel_m_s2[0] == Approx(-9.80665));
  CHECK(outcome.imu[0].accel_m_s2[1] == Approx(9.80665));
  CHECK(outcome.imu[0].gyro_rad_s[0] == Approx(6554 / 65.536 * 3.14159265358979 / 180));
  CHECK(outcome.imu[0].gyro_rad_s[1] == Approx(3277 / 65.536 * 3.14159265358979 / 180));
}

TEST_CASE("iniVation: neither cuts of the input nor small outputs change anything") {
  for (const InivationLayout& layout : {kDavis346, kDvx}) {
    Bytes bytes = stream({time_stamp(7), row(3), dvx_rows(1, 1, false), dvx_column(9), dvx_group(1, 1, 0xff),
                          dvx_group(2, 0, 0xa5), wrap(1)});
    append_imu(bytes, 0xE0, {1, 2, 3, 4, 5, 6, 7});
    append_imu(bytes, 0xC0, {1, 2, 3, 5, 6, 7});
    append(bytes, column(1, 5), 2);
    const Outcome whole = run(layout, bytes);
    REQUIRE(whole.events.size() >= 2);
    REQUIRE(whole.imu.size() == 2);
    for (std::size_t cut = 1; cut <= bytes.size(); ++cut) {
      for (std::size_t room = 1; room <= 10; ++room) {
        const Outcome again = run(layout, bytes, cut, room);
        CHECK(again.events == whole.events);
        CHECK(again.imu.size() == 2);
        CHECK(again.counters.violations == whole.counters.violations);
      }
    }
  }
}

TEST_CASE("iniVation: half a word at the end of a transfer is dropped, and the next one is read right") {
  InivationDecoder decoder(kDavis346);
  Event events[8];
  ImuSample imu[1];
  Bytes bytes = stream({time_stamp(1), row(2)});
  bytes.push_back(std::byte{0x33});
  decoder.feed(bytes, events, imu);
  decoder.end_transfer();
  const InivationDecoded done = decoder.feed(stream({column(1, 3)}), events, imu);
  REQUIRE(done.events == 1);
  CHECK(events[0] == Event{1, 3, 2, 1});
  CHECK(decoder.counters()[InivationViolation::kOddByte] == 1);
}
