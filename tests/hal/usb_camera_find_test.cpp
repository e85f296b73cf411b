// Which camera is meant, and why one cannot be had.
#include <catch2/catch.hpp>
#include <cstring>

#include "usb_cameras.hpp"

using namespace scripted;

namespace {

Status opened(Usb& bus, const UsbCameraSettings& settings = {}) {
  Bench bench(bus, settings);
  const Status status = bench.source.open();
  if (!status.ok()) CHECK(bus.all_closed());
  return status;
}

UsbCameraSettings with_serial(const char* serial) {
  UsbCameraSettings settings;
  std::strcpy(settings.serial, serial);
  return settings;
}

}  // namespace

TEST_CASE("USB: no camera, and what is no camera, is kNoDevice") {
  Usb bus;
  CHECK(opened(bus).code() == StatusCode::kNoDevice);
  Camera webcam = davis346();
  webcam.descriptor.vendor = 0x046D;
  bus.cameras = {webcam};
  CHECK(opened(bus).code() == StatusCode::kNoDevice);
  // Cypress's vendor id with another class is another product.
  Camera other = evk4();
  other.descriptor.interface_subclass = 0;
  bus.cameras = {other};
  CHECK(opened(bus).code() == StatusCode::kNoDevice);
}

TEST_CASE("USB: what is known and cannot be driven says why") {
  const char* why = "";
  CHECK(driver_of(davis346().descriptor, why) == &davis_driver());
  CHECK(driver_of(dvxplorer().descriptor, why) == &dvxplorer_driver());
  CHECK(driver_of(evk4().descriptor, why) == &imx636_driver());
  CHECK(std::string(why).empty());
  UsbDevice mini = dvxplorer().descriptor;
  mini.release = 0x0408;
  CHECK(driver_of(mini, why) == nullptr);
  CHECK(std::string(why).find("Mini") != std::string::npos);
  CHECK(driver_of({.vendor = 0x04B4, .product = 0x8613}, why) == nullptr);
  CHECK(std::string(why).find("without firmware") != std::string::npos);
  CHECK(driver_of({.vendor = 0x03FD, .product = 0x5832}, why) == nullptr);
  CHECK(std::string(why).find("EVK2") != std::string::npos);
}

TEST_CASE("USB: permission, claimed, gone") {
  Usb bus;
  bus.cameras = {davis346()};
  bus.cameras[0].open_error = EACCES;
  CHECK(opened(bus).code() == StatusCode::kNoPermission);
  bus.cameras[0].open_error = ENODEV;
  CHECK(opened(bus).code() == StatusCode::kDeviceLost);
  bus.cameras[0].open_error = 0;
  bus.cameras[0].claim_error = EBUSY;
  CHECK(opened(bus).code() == StatusCode::kDeviceBusy);
  char text[300];
  opened(bus).describe(text);
  CHECK(std::string(text).find("another process holds the device: DAVIS") == 0);
}

TEST_CASE("USB: of two cameras the serial number chooses") {
  Usb bus;
  bus.cameras = {davis346("AAAA"), davis346("BBBB")};
  bus.cameras[1].descriptor.address = 8;
  CHECK(opened(bus).code() == StatusCode::kAmbiguousDevice);
  CHECK(opened(bus).value() == 2);
  CHECK(opened(bus, with_serial("CCCC")).code() == StatusCode::kNoDevice);
  const UsbCameraSettings settings = with_serial("BBBB");
  Bench bench(bus, settings);
  REQUIRE(bench.source.open().ok());
  CHECK(std::string(bench.source.info().serial) == "BBBB");
  CHECK(bus.devices == 1);
  bench.source.stop();
  // One that cannot be opened may be the one that is meant.
  bus.cameras[0].open_error = EACCES;
  CHECK(opened(bus, with_serial("CCCC")).code() == StatusCode::kNoPermission);
}

TEST_CASE("USB: firmware that is not known is refused with both numbers") {
  Usb bus;
  bus.cameras = {davis346()};
  auto& registers = bus.cameras[0].registers;
  SECTION("logic") {
    registers[at(6, 0)] = 19;
    const Status status = opened(bus);
    CHECK(status.code() == StatusCode::kUnknownFirmware);
    CHECK(status.value() == 19);
    CHECK(status.bound() == 18);
    char text[300];
    status.describe(text);
    CHECK(std::string(text).find("unknown firmware: the logic's version is 19, known is 18.") == 0);
  }
  SECTION("patch") {
    registers[at(6, 7)] = 0;
    CHECK(opened(bus).code() == StatusCode::kUnknownFirmware);
  }
  SECTION("controller, FX3") {
    bus.cameras[0].descriptor.release = 0x0005;
    CHECK(opened(bus).code() == StatusCode::kUnknownFirmware);
  }
  SECTION("controller, FX2") {
    bus.cameras[0].descriptor.product = 0x841B;
    bus.cameras[0].descriptor.release = 0x0003;
    registers[at(6, 1)] = 2;
    CHECK(opened(bus).code() == StatusCode::kUnknownFirmware);
    bus.cameras[0].descriptor.release = 0x0004;
    CHECK(opened(bus).ok());
  }
  SECTION("another protocol: the port does not answer") {
    registers.clear();
    CHECK(opened(bus).code() == StatusCode::kUnknownFirmware);
  }
  SECTION("another chip") {
    registers[at(6, 1)] = 8;
    CHECK(opened(bus).code() == StatusCode::kUnsupportedDevice);
  }
  SECTION("a size that no sensor has") {
    registers[at(1, 0)] = 70000;
    CHECK(opened(bus).code() == StatusCode::kUnsupportedDevice);
  }
  SECTION("unplugged between the questions") {
    bus.fail_control_after = 5;
    bus.control_error = ENODEV;
    CHECK(opened(bus).code() == StatusCode::kDeviceLost);
  }
}

TEST_CASE("USB: DVXplorer asks for more, Prophesee for its release, one device and its sensor") {
  Usb bus;
  bus.cameras = {dvxplorer()};
  CHECK(opened(bus).ok());
  bus.cameras[0].registers[at(6, 7)] = 1;
  CHECK(opened(bus).code() == StatusCode::kUnknownFirmware);

  bus.cameras = {evk4()};
  Bench bench(bus);
  REQUIRE(bench.source.open().ok());
  CHECK(std::string(bench.source.info().name) == "EVK4 (IMX636)");
  CHECK(std::string(bench.source.info().serial) == "00050123");
  CHECK(bench.source.info().size.width_px == 1280);
  bench.source.stop();
  SECTION("release") {
    bus.cameras[0].numbers[0x79] = 0x30700;
    CHECK(opened(bus).code() == StatusCode::kUnknownFirmware);
    bus.cameras[0].numbers.erase(0x79);
    CHECK(opened(bus).code() == StatusCode::kUnknownFirmware);
  }
  SECTION("bridge") {
    bus.cameras[0].numbers[0x10000] = 2;
    CHECK(opened(bus).code() == StatusCode::kUnsupportedDevice);
  }
  SECTION("sensor") {
    bus.cameras[0].registers[0x14] = 0xB0602003;
    CHECK(opened(bus).code() == StatusCode::kUnsupportedDevice);
  }
  SECTION("name") {
    bus.cameras[0].texts = "psee,cx3_genx320";
    CHECK(opened(bus).code() == StatusCode::kUnsupportedDevice);
  }
}

TEST_CASE("USB: a Prophesee answer that is not the one asked for is an error, never a value") {
  Usb bus;
  bus.cameras = {evk4()};
  bus.cameras[0].spoil_answer = GENERATE(
      static_cast<void (*)(Bytes&)>([](Bytes& answer) { answer[0] ^= std::byte{1}; }),  // another property
      [](Bytes& answer) { answer[3] |= std::byte{0x80}; },                              // refused
      [](Bytes& answer) { answer[4] = std::byte{200}; },                                // more than came
      [](Bytes& answer) { answer.resize(5); }, [](Bytes& answer) { answer.clear(); },
      [](Bytes& answer) {
        answer.resize(1000);
        answer[4] = std::byte{0xE0};
        answer[5] = std::byte{3};
      });
  const Status status = opened(bus);
  CHECK(status.code() == StatusCode::kUnknownFirmware);
  CHECK(status.value() == 0);
}

TEST_CASE("USB: settings out of range are refused before anything is opened") {
  Usb bus;
  bus.cameras = {davis346()};
  UsbCameraSettings settings;
  SECTION("transfers") {
    settings.transfers = GENERATE(1, 65, -1);
  }
  SECTION("bytes") {
    settings.transfer_bytes = GENERATE(1000, 1025, 2 << 20, -1024);
  }
  SECTION("axes") {
    settings.imu_axes.from[0] = 2;
  }
  CHECK(check_usb_settings(settings).code() == StatusCode::kBadDeviceSetting);
  std::vector<std::byte> buffers(1 << 24);
  const UsbIo io = bus.io();
  UsbCameraSource source(settings, buffers, io, bus.clock.clock());
  CHECK(source.open().code() == StatusCode::kBadDeviceSetting);
}

TEST_CASE("USB: too few buffers name the bytes that are needed") {
  Usb bus;
  bus.cameras = {davis346()};
  std::vector<std::byte> buffers(1000);
  const UsbIo io = bus.io();
  UsbCameraSource source({}, buffers, io, bus.clock.clock());
  const Status status = source.open();
  CHECK(status.code() == StatusCode::kArenaTooSmall);
  CHECK(status.bound() == 20 * 128 * 1024);
  CHECK(bus.all_closed());
}

TEST_CASE("USB: a slow link is one of a device that could do more") {
  UsbDevice davis = davis346().descriptor;
  CHECK_FALSE(is_slow_link(davis));
  davis.speed = UsbSpeed::kHigh;
  CHECK(is_slow_link(davis));
  davis.product = 0x841B;  // the DAVIS240 is a USB 2 device
  CHECK_FALSE(is_slow_link(davis));
}
