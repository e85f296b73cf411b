// The shipped recording: text of a log, through its DBC, to motion samples.
#include "hal/can_bench.hpp"
#include "hal/candump_decoder.hpp"
#include "hal/dbc_files.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;

TEST_CASE("can: the fixture's log becomes motion, no frame is lost") {
  const std::string folder = egofocus::test::source_dir() + "/fixtures/planes/";
  const auto text_of = [&](const char* name) {
    std::ifstream file(folder + name, std::ios::binary);
    REQUIRE(file.good());
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  const auto dbc = read_dbc_text(text_of("vehicle.dbc"));
  Bench bench(
      config_of(
          {entry("IMU_RATE", "GyroX", CanRole::kGyroX, CanUnit::kDegPerSecond),
           entry("IMU_RATE", "GyroY", CanRole::kGyroY, CanUnit::kDegPerSecond),
           entry("IMU_RATE", "GyroZ", CanRole::kGyroZ, CanUnit::kDegPerSecond),
           entry("IMU_FORCE", "AccelX", CanRole::kAccelX), entry("IMU_FORCE", "AccelY", CanRole::kAccelY),
           entry("IMU_FORCE", "AccelZ", CanRole::kAccelZ), entry("BODY_MOTION", "VelX", CanRole::kVelocityX),
           entry("BODY_MOTION", "VelY", CanRole::kVelocityY),
           entry("BODY_MOTION", "VelZ", CanRole::kVelocityZ)}),
      *dbc);
  const std::string log = text_of("can.log");
  CandumpDecoder decoder;
  std::vector<CanFrame> frames(log.size() / 20);
  const Decoded done = decoder.finish(std::as_bytes(std::span(log.data(), log.size())), frames);
  CHECK(done.consumed == log.size());
  CHECK(decoder.counters().frames == decoder.counters().lines);
  CHECK(decoder.counters().out_of_order == 0);
  for (std::size_t i = 0; i < done.produced; ++i) bench.feed(frames[i]);

  CHECK(bench.n().frames_used == done.produced);
  CHECK(bench.n().samples_incomplete == 0);
  CHECK(bench.n().invalid_values == 0);
  CHECK(bench.imu.size() == 2 * 431);   // 2.15 s at 200 Hz, gyro and accelerometer
  CHECK(bench.odometry.size() == 108);  // 50 Hz
  double up = 0;
  for (const ImuSample& sample : bench.imu) up += sample.has_accel ? sample.accel_m_s2[2] : 0;
  CHECK(up / 431 == Approx(9.81).margin(0.3));  // gravity, on the right axis with the right sign
  double fastest = 0;
  for (const OdometrySample& sample : bench.odometry) {
    for (const double v : sample.velocity_m_s) fastest = v > fastest ? v : fastest;
  }
  CHECK(fastest == Approx(1.75).margin(0.15));  // the forward phase
}
