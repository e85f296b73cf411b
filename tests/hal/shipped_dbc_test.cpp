// The DBC files that are installed, against frames made by hand from the makers' tables.
#include <filesystem>
#include <set>

#include "hal/can_bench.hpp"
#include "hal/dbc_files.hpp"

using namespace egofocus;

namespace {

struct Known {
  const char* file;
  const char* message;
  std::uint32_t id;
  bool extended;
  std::vector<std::uint8_t> data;
  const char* signal;
  double value;
};

const Known kKnown[] = {
    // (raw - 0x8000) * 0.005 deg/s; (raw - 0x8000) * 0.000127465 g
    {"bosch_mm.dbc", "MM_TX1", 0x174, false, {0xD0, 0x87, 0x30, 75, 0x11, 0x83, 0x24, 0xAB}, "YawRate", 10},
    {"bosch_mm.dbc",
     "MM_TX1",
     0x174,
     false,
     {0xD0, 0x87, 0x30, 75, 0x11, 0x83, 0x24, 0xAB},
     "YawRateStatus",
     3},
    {"bosch_mm.dbc",
     "MM_TX1",
     0x174,
     false,
     {0xD0, 0x87, 0x30, 75, 0x11, 0x83, 0x24, 0xAB},
     "Temperature",
     25},
    {"bosch_mm.dbc",
     "MM_TX1",
     0x174,
     false,
     {0xD0, 0x87, 0x30, 75, 0x11, 0x83, 0x24, 0xAB},
     "AccelY",
     0x311 * 0.000127465},
    {"bosch_mm.dbc", "MM_TX1", 0x174, false, {0xD0, 0x87, 0x30, 75, 0x11, 0x83, 0x24, 0xAB}, "Counter1", 4},
    {"bosch_mm.dbc",
     "MM_TX1",
     0x174,
     false,
     {0xD0, 0x87, 0x30, 75, 0x11, 0x83, 0x24, 0xAB},
     "AccelYStatus",
     2},
    {"bosch_mm.dbc", "MM_TX1", 0x174, false, {0xD0, 0x87, 0x30, 75, 0x11, 0x83, 0x24, 0xAB}, "Crc1", 0xAB},
    {"bosch_mm.dbc", "MM_TX2", 0x178, false, {0x60, 0x70, 0, 0, 0, 0x80, 0, 0}, "RollRate", -20},
    {"bosch_mm.dbc", "MM_TX3", 0x17C, false, {0xE8, 0x83, 0, 0, 0xA5, 0x9E, 0, 0}, "PitchRate", 5},
    {"bosch_mm.dbc",
     "MM_TX3",
     0x17C,
     false,
     {0xE8, 0x83, 0, 0, 0xA5, 0x9E, 0, 0},
     "AccelZ",
     0x1EA5 * 0.000127465},
    {"bosch_abs_m5.dbc", "ABS_Yaw", 0x70, false, {0xD0, 0x87, 0, 0, 0x11, 0x83, 0, 0}, "YawRate", 10},
    {"bosch_abs_m5.dbc",
     "ABS_Roll",
     0x80,
     false,
     {0, 0x80, 0, 0, 0xEF, 0x7C, 0, 0},
     "AccelX",
     -0x311 * 0.000127465},
    {"bosch_abs_m5.dbc",
     "ABS_Vertical",
     0x576,
     false,
     {0, 0, 0, 0, 0xA5, 0x9E, 0, 0},
     "AccelZ",
     0x1EA5 * 0.000127465},
    {"bosch_abs_m5.dbc", "ABS_Wheels", 0x24A, false, {0x80, 0x02, 0x40, 0x01, 0, 0, 1, 0}, "WheelFl", 10},
    {"bosch_abs_m5.dbc", "ABS_Wheels", 0x24A, false, {0x80, 0x02, 0x40, 0x01, 0, 0, 1, 0}, "WheelFr", 5},
    {"bosch_abs_m5.dbc",
     "ABS_Wheels",
     0x24A,
     false,
     {0x80, 0x02, 0x40, 0x01, 0, 0, 1, 0},
     "WheelRr",
     0.015625},
    {"j1939_imu.dbc",
     "ARI",
     0x18F02A80,
     true,
     {0x00, 0x82, 0x00, 0x7D, 0x80, 0x7C, 0x24, 8},
     "PitchRate",
     10},
    {"j1939_imu.dbc", "ARI", 0x18F02A80, true, {0x00, 0x82, 0x00, 0x7D, 0x80, 0x7C, 0x24, 8}, "YawRate", -1},
    {"j1939_imu.dbc",
     "ARI",
     0x18F02A80,
     true,
     {0x00, 0x82, 0x00, 0x7D, 0x80, 0x7C, 0x24, 8},
     "RollRateMerit",
     1},
    {"j1939_imu.dbc",
     "ARI",
     0x18F02A80,
     true,
     {0x00, 0x82, 0x00, 0x7D, 0x80, 0x7C, 0x24, 8},
     "YawRateMerit",
     2},
    {"j1939_imu.dbc",
     "ARI",
     0x18F02A80,
     true,
     {0x00, 0x82, 0x00, 0x7D, 0x80, 0x7C, 0x24, 8},
     "AriLatency",
     4},
    {"j1939_imu.dbc",
     "ACCS",
     0x18F02D80,
     true,
     {0x64, 0x7D, 0x00, 0x7D, 0xD5, 0x80, 0, 0},
     "LateralAccel",
     1},
    {"j1939_imu.dbc",
     "ACCS",
     0x18F02D80,
     true,
     {0x64, 0x7D, 0x00, 0x7D, 0xD5, 0x80, 0, 0},
     "VerticalAccel",
     9.81},
    // (250 + 90) * 32768 = 0xAA0000; (250 - 2.5) * 32768 = 0x7BC000
    {"j1939_imu.dbc", "SSI2", 0x0CF02980, true, {0x00, 0x00, 0xAA, 0x00, 0xC0, 0x7B, 0, 0}, "Pitch", 90},
    {"j1939_imu.dbc", "SSI2", 0x0CF02980, true, {0x00, 0x00, 0xAA, 0x00, 0xC0, 0x7B, 0, 0}, "Roll", -2.5},
    // (64 + 1) / 0.002 = 0x7EF4
    {"j1939_imu.dbc", "SSI", 0x18F01380, true, {0xF4, 0x7E, 0x00, 0x7D, 0xF4, 0x7E, 0, 0}, "Pitch", 1},
    {"j1939_imu.dbc", "SSI", 0x18F01380, true, {0xF4, 0x7E, 0x00, 0x7D, 0xF4, 0x7E, 0, 0}, "Roll", 0},
    {"j1939_imu.dbc", "SSI", 0x18F01380, true, {0xF4, 0x7E, 0x00, 0x7D, 0xF4, 0x7E, 0, 0}, "PitchRate", 1},
    {"xsens_mti.dbc", "Error", 0x1, false, {1}, "Error", 1},
    {"xsens_mti.dbc", "SampleTime", 0x5, false, {0xFF, 0xFF, 0xFF, 0xFE}, "SampleTime", 4294967294.0},
    {"xsens_mti.dbc", "GroupCounter", 0x6, false, {0x12, 0x34}, "GroupCounter", 0x1234},
    {"xsens_mti.dbc", "Status", 0x11, false, {0x80, 0, 0, 1}, "Status", 2147483649.0},
    {"xsens_mti.dbc", "RateOfTurn", 0x32, false, {0x02, 0x00, 0xFE, 0x00, 0x00, 0x01}, "GyrY", -1},
    {"xsens_mti.dbc", "RateOfTurn", 0x32, false, {0x02, 0x00, 0xFE, 0x00, 0x00, 0x01}, "GyrZ", 1.0 / 512},
    {"xsens_mti.dbc", "Acceleration", 0x34, false, {0x00, 0x80, 0x01, 0x00, 0xF6, 0x31}, "AccZ", -9.80859375},
    {"xsens_mti.dbc", "FreeAcceleration", 0x35, false, {0x00, 0x80, 0x01, 0x00, 0xFF, 0x00}, "FreeAccZ", -1},
    {"xsens_mti.dbc", "RateOfTurnHR", 0x61, false, {0x04, 0x00, 0, 0, 0, 0}, "GyrHrX", 2},
    {"xsens_mti.dbc", "AccelerationHR", 0x62, false, {0, 0, 0, 0, 0x09, 0xCF}, "AccHrZ", 9.80859375},
    {"xsens_mti.dbc", "Velocity", 0x76, false, {0x00, 0x40, 0xFF, 0xC0, 0x00, 0x00}, "VelY", -1},
    {"racelogic_imu03.dbc", "IMU03_2", 0x601, false, {0xBE, 0x80, 0, 0, 0x41, 0xC8, 0, 0}, "Y_Accel", -0.25},
    {"racelogic_imu03.dbc", "IMU03_2", 0x601, false, {0xBE, 0x80, 0, 0, 0x41, 0xC8, 0, 0}, "Temp", 25},
    {"wheels_examples.dbc", "GmWheelsFront", 0x348, false, {0x00, 0x64, 0x00, 0xC8, 0}, "GmFr", 200 * 0.0311},
};

}  // namespace

TEST_CASE("shipped DBC: frames from the makers' tables have the values that the tables say") {
  for (const Known& known : kKnown) {
    INFO(known.file << " " << known.message << " " << known.signal);
    const auto dbc = read_shipped_dbc(known.file);
    const DbcMessage* message = dbc->find_message(known.message);
    REQUIRE(message != nullptr);
    CHECK(message->id == known.id);
    CHECK(message->extended == known.extended);
    CHECK(message->length == known.data.size());
    CHECK(message->parameter_group == known.extended);
    const DbcSignal* signal = dbc->find_signal(*message, known.signal);
    REQUIRE(signal != nullptr);
    double value = 0;
    REQUIRE(decode_signal(*signal, known.data, value));
    CHECK(value == Approx(known.value).epsilon(1e-9).margin(4e-5));
    // And back: the same bits, and no others.
    std::vector<std::uint8_t> again = known.data;
    REQUIRE(encode_signal(*signal, known.value, again));
    CHECK(again == known.data);
  }
}

TEST_CASE("shipped DBC: every file is read, and none of its signals shares a bit with another") {
  std::set<std::string> tested;
  for (const Known& known : kKnown) tested.insert(known.file);
  std::set<std::string> shipped;
  for (const auto& entry : std::filesystem::directory_iterator(test::source_dir() + "/dbc")) {
    if (entry.path().extension() == ".dbc") shipped.insert(entry.path().filename().string());
  }
  CHECK(shipped == tested);
  for (const std::string& file : shipped) {
    const auto dbc = read_shipped_dbc(file);
    for (std::size_t m = 0; m < dbc->message_count; ++m) {
      const DbcMessage& message = dbc->messages[m];
      std::vector<std::uint8_t> taken(message.length, 0);
      for (std::size_t s = 0; s < message.signal_count; ++s) {
        const DbcSignal& signal = dbc->signals[message.first_signal + s];
        INFO(file << " " << message.name << " " << signal.name);
        std::vector<std::uint8_t> own(message.length, 0);
        REQUIRE(encode_raw(signal, ~std::uint64_t{0}, own));
        for (std::size_t i = 0; i < own.size(); ++i) {
          CHECK((taken[i] & own[i]) == 0);
          taken[i] = static_cast<std::uint8_t>(taken[i] | own[i]);
        }
      }
    }
  }
}
