// What is written to a camera, in which order and with which waits: against lists made by hand from the
// cameras' documentation, not from the tables of the library.
#include <catch2/catch.hpp>
#include <cstring>
#include <sstream>
#include <string>

#include "usb_cameras.hpp"

using namespace scripted;

namespace {

using Writes = std::vector<Write>;

const std::vector<Write>& started(Bench& bench) {
  REQUIRE(bench.stream());
  return bench.bus.cameras[0].writes;
}

std::uint32_t value_of(const Writes& writes, std::uint32_t address) {
  std::uint32_t value = 0xdead;
  for (const Write& write : writes) {
    if (write.address == address) value = write.value;
  }
  return value;
}

std::size_t place_of(const Writes& writes, const Write& wanted, std::size_t from = 0) {
  for (std::size_t i = from; i < writes.size(); ++i) {
    if (writes[i] == wanted) return i;
  }
  return SIZE_MAX;
}

UsbBias bias(const char* name, int coarse, int fine, int offset = 0) {
  UsbBias made{.coarse = coarse, .fine = fine, .offset = offset};
  std::strcpy(made.name, name);
  return made;
}

// The sequences as they are published, "register=value" in hexadecimal, "w" and a wait in us.
constexpr const char* kDestroyText =
    "0070=400008 006C=EE47114 w500 A00C=20400 w500 A010=8068 w200 1104=0 w200 A020=50 w200 A004=B0500 "
    "w200 A008=2404 w200 A000=B0500 B044=0 B004=A B040=E B0C8=0 B040=6 B040=4 0000=4F006442 "
    "0000=0F006442 00B8=401 00B8=400 B07C=0";
constexpr const char* kInitText =
    "001C=1 w1000000 400004=1 w500000 400004=0 w1000000 B000=158 w300 B044=0 B004=A B040=0 B0C8=0 "
    "B040=0 B040=0 0000=4F006442 0000=0F006442 00B8=400 00B8=400 B07C=0 B074=2 B078=A0 00C0=110 "
    "00C0=210 B120=1 E120=0 B068=4 B07C=1 w10 B07C=3 w1000 00B8=401 00B8=409 0000=4F006442 "
    "0000=4F00644A B080=77 B084=F B088=37 B08C=37 B090=DF B094=57 B098=37 B09C=67 B0A0=37 B0A4=2F "
    "B0AC=28 B0CC=1 B000=2F8 B004=8A B01C=30 B020=2000 B02C=FF B030=3E80 B028=FA0 A000=B0501 w200 "
    "A008=2405 w200 A004=B0501 w200 A020=150 w200 B040=7 B064=6 B040=F w100 B004=8A w200 B0C8=3 w200 "
    "B044=1 B000=2F9 7008=1 7000=70001 8000=1E085 9008=644 0004=F0005042 0018=200 1014=11A1504D "
    "9004=0 w1000 9000=200";

// Compares `text` with what was written from `at` on, waits included; returns the place behind it.
std::size_t check_sequence(const Writes& writes, std::size_t at, const std::string& text) {
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    INFO(word);
    if (word[0] == 'w') {
      CHECK(writes.at(at).at_us - writes.at(at - 1).at_us >= std::stol(word.substr(1)));
      continue;
    }
    const std::size_t equals = word.find('=');
    CHECK(writes.at(at).address == std::stoul(word.substr(0, equals), nullptr, 16));
    CHECK(writes.at(at).value == std::stoul(word.substr(equals + 1), nullptr, 16));
    ++at;
  }
  return at;
}

}  // namespace

TEST_CASE("DAVIS346: biases in the bits of the data sheet") {
  Usb bus;
  bus.cameras = {davis346()};
  Bench bench(bus);
  const Writes& writes = started(bench);
  // Coarse << 12 | fine << 4 | normal current 8 | no cascode 4 | N type 2 | on 1.
  CHECK(value_of(writes, at(5, 10)) == 4 * 4096 + 39 * 16 + 15);   // DiffBn
  CHECK(value_of(writes, at(5, 11)) == 5 * 4096 + 255 * 16 + 15);  // OnBn
  CHECK(value_of(writes, at(5, 12)) == 4 * 4096 + 1 * 16 + 15);    // OffBn
  CHECK(value_of(writes, at(5, 14)) == 2 * 4096 + 58 * 16 + 13);   // PrBp, P type
  CHECK(value_of(writes, at(5, 9)) == 7 * 4096 + 215 * 16 + 14);   // PadFollBn, off
  CHECK(value_of(writes, at(5, 20)) == 1 * 16 + 15);               // ColSelLowBn, coarse 0
  CHECK(value_of(writes, at(5, 0)) == 27 + 6 * 64);                // ApsOverflowLevel, voltage
  CHECK(value_of(writes, at(5, 35)) == 1 * 16 + 33 * 1024);        // SSP, shifted source
  std::size_t biases = 0;
  for (const Write& write : writes) biases += write.address >= at(5, 0) && write.address < at(5, 128);
  CHECK(biases == 28);
  CHECK(value_of(writes, at(5, 136)) == 1);
  CHECK(value_of(writes, at(5, 138)) == 1);
  CHECK(value_of(writes, at(5, 139)) == 0xdead);  // 240A and 240B alone
  CHECK(value_of(writes, at(5, 143)) == 1);
  CHECK(value_of(writes, at(5, 144)) == 0);
}

TEST_CASE("DAVIS240: its own biases") {
  Usb bus;
  bus.cameras = {davis346()};
  bus.cameras[0].registers[at(6, 1)] = 2;
  bus.cameras[0].registers[at(1, 0)] = 240;
  bus.cameras[0].registers[at(1, 1)] = 180;
  Bench bench(bus);
  const Writes& writes = started(bench);
  CHECK(std::string(bench.source.info().name) == "DAVIS240");
  CHECK(value_of(writes, at(5, 0)) == 4 * 4096 + 39 * 16 + 15);   // DiffBn
  CHECK(value_of(writes, at(5, 3)) == 5 * 4096 + 185 * 16 + 11);  // ApsCasEpc, N cascode
  CHECK(value_of(writes, at(5, 20)) == 1 * 16 + 33 * 1024);       // SSP
  CHECK(value_of(writes, at(5, 143)) == 0xdead);
  CHECK(value_of(writes, at(1, 43)) == 239);
  CHECK(value_of(writes, at(1, 44)) == 179);
}

TEST_CASE("DAVIS: the logic is set up, then started in the documented order with its waits") {
  Usb bus;
  bus.cameras = {davis346()};
  UsbCameraSettings settings;
  settings.imu = true;
  Bench bench(bus, settings);
  const Writes& writes = started(bench);
  CHECK(value_of(writes, at(0, 4)) == 1);  // the camera drops when the host is slow, and counts
  CHECK(value_of(writes, at(0, 5)) == 1);
  CHECK(value_of(writes, at(1, 11)) == 260);  // pixel filter 0 off: its row and column lie outside
  CHECK(value_of(writes, at(1, 12)) == 346);
  CHECK(value_of(writes, at(1, 26)) == 346);
  CHECK(value_of(writes, at(1, 31)) == 0);      // true contours have isolated events
  CHECK(value_of(writes, at(9, 1)) == 80'000);  // 8 * 125 us of 80 MHz
  CHECK(value_of(writes, at(3, 7)) == 1);
  CHECK(value_of(writes, at(3, 10)) == 1);
  CHECK(value_of(writes, at(2, 4)) == 0);

  const std::size_t chip_off = place_of(writes, {at(0, 3), 0});
  const std::size_t chip_on = place_of(writes, {at(0, 3), 1});
  REQUIRE(chip_on == chip_off + 1);
  CHECK(writes[chip_on].at_us - writes[chip_off].at_us >= 10'000);
  for (const std::uint32_t off :
       {at(1, 3), at(3, 2), at(3, 3), at(3, 4), at(4, 0), at(0, 0), at(0, 1), at(9, 0)}) {
    CHECK(place_of(writes, {off, 0}) < chip_off);
  }
  const Writes tail(writes.begin() + static_cast<std::ptrdiff_t>(chip_on), writes.end());
  CHECK(tail == Writes{{at(0, 3), 1},
                       {at(9, 0), 1},
                       {at(0, 1), 1},
                       {at(0, 0), 1},
                       {at(0, 2), 1},
                       {at(0, 2), 0},
                       {at(1, 3), 1},
                       {at(3, 2), 1},
                       {at(3, 3), 1},
                       {at(3, 4), 1}});
  CHECK(tail[1].at_us - tail[0].at_us >= 200'000);
  CHECK(tail[4].at_us - tail[3].at_us >= 50'000);
  CHECK(tail[5].at_us == tail[4].at_us);  // one request
  CHECK(bus.halts_cleared == 1);
  CHECK(bus.in_flight() == 16);
  CHECK(bus.timeout_ms() == 0);

  bus.cameras[0].writes.clear();
  bench.source.stop();
  CHECK(bus.cameras[0].writes == Writes{{at(1, 3), 0},
                                        {at(3, 2), 0},
                                        {at(3, 3), 0},
                                        {at(3, 4), 0},
                                        {at(4, 0), 0},
                                        {at(0, 0), 0},
                                        {at(0, 1), 0},
                                        {at(9, 0), 0},
                                        {at(0, 3), 0}});
  CHECK(bus.all_closed());
}

TEST_CASE("DAVIS: a slave's clock is left to its master, the IMU off unless asked for") {
  Usb bus;
  bus.cameras = {davis346()};
  bus.cameras[0].registers[at(6, 2)] = 0;
  Bench bench(bus);
  const Writes& writes = started(bench);
  CHECK(place_of(writes, {at(0, 2), 1}) == SIZE_MAX);
  CHECK(value_of(writes, at(3, 3)) == 0);
}

TEST_CASE("DAVIS: the early-packet timer counts the true clock") {
  Usb bus;
  bus.cameras = {davis346()};
  bus.cameras[0].registers[at(6, 6)] = 950;  // 76 MHz
  Bench bench(bus);
  CHECK(value_of(started(bench), at(9, 1)) == 76'000);
}

TEST_CASE("DAVIS: biases of the settings take the place of the default ones, wrong ones are refused") {
  Usb bus;
  bus.cameras = {davis346()};
  UsbCameraSettings settings;
  settings.bias_count = 1;
  SECTION("good") {
    settings.biases[0] = bias("OnBn", 6, 10);
    Bench bench(bus, settings);
    CHECK(value_of(started(bench), at(5, 11)) == 6 * 4096 + 10 * 16 + 15);
  }
  SECTION("wrong") {
    settings.biases[0] =
        GENERATE(bias("OnBm", 1, 1), bias("OnBn", 8, 1), bias("OnBn", 1, 256), bias("OnBn", -1, 1),
                 bias("OnBn", 1, -1), bias("ApsCas", 1, 1), bias("", 1, 1));
    Bench bench(bus, settings);
    CHECK(bench.source.start().code() == StatusCode::kBadDeviceSetting);
    CHECK(bus.all_closed());
  }
}

TEST_CASE("DVXplorer: chip registers, preset and order") {
  Usb bus;
  bus.cameras = {dvxplorer()};
  UsbCameraSettings settings;
  settings.sensitivity = UsbSensitivity::kHigh;
  Bench bench(bus, settings);
  const Writes& writes = started(bench);
  CHECK(value_of(writes, at(5, 0x000B)) == 0x04);
  CHECK(value_of(writes, at(5, 0x0012)) == 0x7F);
  CHECK(value_of(writes, at(5, 0x001C)) == 0x05);
  CHECK(value_of(writes, at(5, 0x001E)) == 0x03);
  CHECK(value_of(writes, at(5, 0x3235)) * 256 + value_of(writes, at(5, 0x3236)) == 999);
  CHECK(value_of(writes, at(5, 0x325D)) * 256 + value_of(writes, at(5, 0x325E)) == 45000);
  CHECK(value_of(writes, at(5, 0x3067)) == 0x80);
  const std::size_t chip_on = place_of(writes, {at(0, 3), 1});
  CHECK(writes[chip_on + 1].at_us - writes[chip_on].at_us >= 10'000);
  CHECK(place_of(writes, {at(0, 0), 1}) > place_of(writes, {at(5, 0x3500), 1}));
  const std::size_t n = writes.size();
  CHECK(Writes(writes.end() - 3, writes.end()) ==
        Writes{{at(5, 0x3238), 1}, {at(5, 0x3238), 0}, {at(5, 0x3000), 2}});
  bench.source.stop();
  CHECK(bus.cameras[0].writes[n] == Write{at(5, 0x3000), 0});
  CHECK(bus.all_closed());
}

TEST_CASE("DVXplorer has no biases by name") {
  Usb bus;
  bus.cameras = {dvxplorer()};
  UsbCameraSettings settings;
  settings.bias_count = 1;
  settings.biases[0] = bias("OnBn", 1, 1);
  Bench bench(bus, settings);
  CHECK(bench.source.start().code() == StatusCode::kBadDeviceSetting);
}

TEST_CASE("IMX636: stop, destroy, init, biases, start") {
  Usb bus;
  bus.cameras = {evk4()};
  // Power-up values: the factory's trim, and bits that a start changes alone.
  bus.cameras[0].registers[0x1010] = 0x11A15066;
  bus.cameras[0].registers[0x1018] = 0x11A14049;
  bus.cameras[0].registers[0x0004] = 0xF0005442;
  UsbCameraSettings settings;
  settings.bias_count = 2;
  settings.biases[0] = bias("diff_on", -1, -1, 20);
  settings.biases[1] = bias("diff_off", -1, -1, -9);
  Bench bench(bus, settings);
  const std::int64_t before_us = bus.clock.now_us();
  const Writes& writes = started(bench);
  CHECK(bus.clock.now_us() - before_us >= 2'500'000);
  CHECK(Writes(writes.begin(), writes.begin() + 5) ==
        Writes{{0x0004, 0xF0005042}, {0x002C, 0x22C324}, {0x9028, 2}, {0x9008, 0}, {0xB000, 0x2F8}});
  check_sequence(writes, check_sequence(writes, 5, kDestroyText), kInitText);
  CHECK(value_of(writes, 0x7000) == 0x70001);
  CHECK(value_of(writes, 0x8000) == 0x1E085);
  CHECK(value_of(writes, 0x1010) == 0x11A1507A);
  CHECK(value_of(writes, 0x1018) == 0x11A14040);
  // 644 and F0005042 are what init leaves; the start sets one bit of each.
  CHECK(Writes(writes.end() - 5, writes.end()) ==
        Writes{{0xB000, 0x2F9}, {0x9028, 0}, {0x9008, 0x645}, {0x002C, 0x22C724}, {0x0004, 0xF0005442}});
  CHECK(bus.in_flight() == 20);
  CHECK(bus.timeout_ms() == 100);

  const std::size_t n = writes.size();
  bench.source.stop();
  CHECK(Writes(bus.cameras[0].writes.begin() + static_cast<std::ptrdiff_t>(n), bus.cameras[0].writes.end()) ==
        Writes{{0x0004, 0xF0005042}, {0x002C, 0x22C324}, {0x9028, 2}, {0x9008, 0x644}, {0xB000, 0x2F8}});
  CHECK(bus.all_closed());
}

TEST_CASE("IMX636: biases out of range, unknown or with codes, and an IMU, are refused") {
  Usb bus;
  bus.cameras = {evk4()};
  UsbCameraSettings settings;
  SECTION("bias") {
    settings.bias_count = 1;
    settings.biases[0] = GENERATE(bias("diff_on", -1, -1, 141), bias("diff_on", -1, -1, -86),
                                  bias("fo", 1, -1, 0), bias("pr", -1, -1, 1), bias("OnBn", 1, 1));
  }
  SECTION("imu") {
    settings.imu = true;
  }
  Bench bench(bus, settings);
  CHECK(bench.source.start().code() == StatusCode::kBadDeviceSetting);
  CHECK(bus.all_closed());
}

TEST_CASE("each request of a start sequence may fail: all is closed, and it is tried again") {
  for (const Camera& camera : {davis346(), dvxplorer(), evk4()}) {
    int requests = 0;
    {
      Usb bus;
      bus.cameras = {camera};
      Bench bench(bus);
      bus.fail_control_after = 1'000'000;
      REQUIRE(bench.stream());
      requests = 1'000'000 - bus.fail_control_after;
    }
    REQUIRE(requests > 50);
    for (int good = 0; good < requests; ++good) {
      Usb bus;
      bus.cameras = {camera};
      Bench bench(bus);
      bus.fail_control_after = good;
      const Status status = bench.source.start();
      for (int i = 0; status.ok() && i < 400 && bench.source.counters().lost == 0; ++i) bench.poll();
      CHECK((!status.ok() || bench.source.counters().lost == 1));
      CHECK(bus.all_closed());
      bus.fail_control_after = -1;
      if (status.ok()) CHECK(bench.poll_until(UsbCameraPhase::kStreaming));
      bench.source.stop();
      CHECK(bus.all_closed());
    }
  }
}
