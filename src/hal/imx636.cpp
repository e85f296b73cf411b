// Prophesee EVK3 and EVK4 with IMX636. Register sequences: OpenEB (Apache-2.0),
// hal_psee_plugins/include/devices/imx636/imx636_evk3_issd.h; the rest: src/devices/imx636 and
// src/boards/treuzell of the same.
#include <array>
#include <cstring>
#include <string_view>

#include "hal/device_status.hpp"
#include "hal/treuzell_port.hpp"
#include "hal/usb_camera.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kChipIdAddress = 0x14;
constexpr std::uint32_t kChipId = 0xA0401806;
constexpr std::uint32_t kRelatedSensorAddress = 0xF128;  // bits 1..0 are 0 in an IMX636
constexpr std::uint32_t kOldestRelease = 0x30800;        // 3.8.0
constexpr SensorSize kSize{1280, 720};

constexpr UsbStep write(std::uint32_t address, std::uint32_t value, std::uint32_t wait_us = 0) noexcept {
  return {.kind = UsbStepKind::kWrite, .address = address, .value = value, .mask = 0, .wait_us = wait_us};
}
constexpr UsbStep set(std::uint32_t address, std::uint32_t mask, std::uint32_t value,
                      std::uint32_t wait_us = 0) noexcept {
  return {.kind = UsbStepKind::kSet, .address = address, .value = value, .mask = mask, .wait_us = wait_us};
}

constexpr UsbStep kInit[] = {
    write(0x001C, 0x1, 1'000'000),
    write(0x400004, 0x1, 500'000),
    write(0x400004, 0x0, 1'000'000),
    write(0xB000, 0x158, 300),
    write(0xB044, 0x0),
    write(0xB004, 0xA),
    write(0xB040, 0x0),
    write(0xB0C8, 0x0),
    write(0xB040, 0x0),
    write(0xB040, 0x0),
    write(0x0000, 0x4F006442),
    write(0x0000, 0x0F006442),
    write(0x00B8, 0x400),
    write(0x00B8, 0x400),
    write(0xB07C, 0x0),
    write(0xB074, 0x2),
    write(0xB078, 0xA0),
    write(0x00C0, 0x110),
    write(0x00C0, 0x210),
    write(0xB120, 0x1),
    write(0xE120, 0x0),
    write(0xB068, 0x4),
    write(0xB07C, 0x1, 10),
    write(0xB07C, 0x3, 1000),
    write(0x00B8, 0x401),
    write(0x00B8, 0x409),
    write(0x0000, 0x4F006442),
    write(0x0000, 0x4F00644A),
    write(0xB080, 0x77),
    write(0xB084, 0xF),
    write(0xB088, 0x37),
    write(0xB08C, 0x37),
    write(0xB090, 0xDF),
    write(0xB094, 0x57),
    write(0xB098, 0x37),
    write(0xB09C, 0x67),
    write(0xB0A0, 0x37),
    write(0xB0A4, 0x2F),
    write(0xB0AC, 0x28),
    write(0xB0CC, 0x1),
    write(0xB000, 0x2F8),
    write(0xB004, 0x8A),
    write(0xB01C, 0x30),
    write(0xB020, 0x2000),
    write(0xB02C, 0xFF),
    write(0xB030, 0x3E80),
    write(0xB028, 0xFA0),
    write(0xA000, 0xB0501, 200),
    write(0xA008, 0x2405, 200),
    write(0xA004, 0xB0501, 200),
    write(0xA020, 0x150, 200),
    write(0xB040, 0x7),
    write(0xB064, 0x6),
    write(0xB040, 0xF, 100),
    write(0xB004, 0x8A, 200),
    write(0xB0C8, 0x3, 200),
    write(0xB044, 0x1),
    write(0xB000, 0x2F9),
    write(0x7008, 0x1),
    write(0x7000, 0x70001),  // EVT3
    write(0x8000, 0x1E085),  // bits 7..6 = 2: 16-bit words, little-endian
    write(0x9008, 0x644),
    write(0x0004, 0xF0005042),
    write(0x0018, 0x200),
    write(0x1014, 0x11A1504D),
    write(0x9004, 0x0, 1000),
    write(0x9000, 0x200),
};

constexpr UsbStep kStart[] = {
    write(0xB000, 0x2F9),    write(0x9028, 0x0),        set(0x9008, 0x1, 0x1),
    write(0x002C, 0x22C724), set(0x0004, 0x400, 0x400),
};

constexpr UsbStep kStop[] = {
    set(0x0004, 0x400, 0x0), write(0x002C, 0x22C324),   write(0x9028, 0x2, 1000),
    set(0x9008, 0x1, 0x0),   write(0xB000, 0x2F8, 300),
};

constexpr UsbStep kDestroy[] = {
    write(0x0070, 0x400008),     write(0x006C, 0xEE47114, 500),
    write(0xA00C, 0x20400, 500), write(0xA010, 0x8068, 200),
    write(0x1104, 0x0, 200),     write(0xA020, 0x50, 200),
    write(0xA004, 0xB0500, 200), write(0xA008, 0x2404, 200),
    write(0xA000, 0xB0500),      write(0xB044, 0x0),
    write(0xB004, 0xA),          write(0xB040, 0xE),
    write(0xB0C8, 0x0),          write(0xB040, 0x6),
    write(0xB040, 0x4),          write(0x0000, 0x4F006442),
    write(0x0000, 0x0F006442),   write(0x00B8, 0x401),
    write(0x00B8, 0x400),        write(0xB07C, 0x0),
};

struct BiasRow {
  std::string_view name;
  std::uint32_t address;
  std::int32_t min;
  std::int32_t max;
};

constexpr BiasRow kBiases[] = {{"fo", 0x1004, -35, 55},        {"hpf", 0x100C, 0, 120},
                               {"diff_on", 0x1010, -85, 140},  {"diff", 0x1014, -25, 23},
                               {"diff_off", 0x1018, -35, 190}, {"refr", 0x1020, -20, 235}};

Status add_biases(const UsbCameraSettings& settings, UsbSteps& steps) noexcept {
  for (std::size_t i = 0; i < settings.bias_count; ++i) {
    const UsbBias& bias = settings.biases[i];
    const BiasRow* row = nullptr;
    for (const BiasRow& candidate : kBiases) {
      if (candidate.name == bias.name) row = &candidate;
    }
    if (row == nullptr || bias.coarse != -1 || bias.fine != -1) {
      return {StatusCode::kBadDeviceSetting,
              "a bias of an IMX636: fo, hpf, diff_on, diff, diff_off, refr with `offset`; counted from 0",
              static_cast<std::int64_t>(i)};
    }
    if (bias.offset < row->min || bias.offset > row->max) {
      return {StatusCode::kBadDeviceSetting, "offset of a bias of an IMX636", bias.offset};
    }
    // The factory's trim is what stands there after the reset of the initialisation.
    steps.add({.kind = UsbStepKind::kOffset,
               .address = row->address,
               .value = static_cast<std::uint32_t>(bias.offset)});
  }
  return {};
}

// The answer is a list of texts, each with its NUL.
bool names_imx636(std::span<const std::byte> answer) noexcept {
  const std::string_view texts(reinterpret_cast<const char*>(answer.data()), answer.size());
  return texts.find("psee,ccam5_imx636") != std::string_view::npos;
}

Status identify(UsbConnection& usb, UsbCameraInfo& info) noexcept {
  constexpr Status kMute{StatusCode::kUnknownFirmware, "the release version, which the camera does not tell,",
                         0, kOldestRelease};
  std::uint64_t number = 0;
  if (const int error = treuzell_read_number(usb, kReleaseVersion, number); error != 0)
    return error == ENODEV ? device_status(error, info.name) : kMute;
  info.logic = static_cast<std::uint32_t>(number);
  if (number < kOldestRelease)
    return {StatusCode::kUnknownFirmware, "the release version", static_cast<std::int64_t>(number),
            kOldestRelease};
  if (treuzell_read_number(usb, kSerialNumber, number) == 0) {
    constexpr char kDigits[] = "0123456789abcdef";
    for (std::size_t i = 0; i < 16; ++i) info.serial[i] = kDigits[number >> (60 - 4 * i) & 15];
    const std::size_t zeros = number >> 32 == 0 ? 8 : 0;  // older kits have 32 bits
    std::memmove(info.serial, info.serial + zeros, 17 - zeros);
  }

  // More than one device would mean a bridge with a stream switch of its own, whose use is not documented.
  if (const int error = treuzell_read_number(usb, kDeviceCount, number); error != 0)
    return device_status(error, info.name);
  if (number != 1)
    return {StatusCode::kUnsupportedDevice, "a Prophesee kit that is more than a sensor and its USB bridge"};
  const std::array<std::uint32_t, 1> sensor{0};
  std::array<std::byte, 256> texts{};
  std::size_t got = 0;
  int error = treuzell_ask(usb, kDeviceCompatible, sensor, texts, got);
  if (error != 0) return device_status(error, info.name);
  std::uint32_t related = 0;
  error = treuzell_read(usb, kChipIdAddress, info.chip);
  if (error == 0) error = treuzell_read(usb, kRelatedSensorAddress, related);
  if (error != 0) return device_status(error, info.name);
  if (!names_imx636(std::span(texts).first(got)) || info.chip != kChipId || (related & 3) != 0)
    return {StatusCode::kUnsupportedDevice, "a Prophesee kit with another sensor than the IMX636", info.chip};
  info.name = info.device.product == 0x00F5 ? "EVK4 (IMX636)" : "EVK3 (IMX636)";
  info.size = kSize;
  return {};
}

Status add_start(const UsbCameraSettings& settings, const UsbCameraInfo&, UsbSteps& steps) noexcept {
  if (settings.imu)
    return {StatusCode::kBadDeviceSetting, "imu = true, but no IMU is read from a Prophesee kit", 1};
  steps.add(kStop);
  steps.add(kDestroy);
  steps.add(kInit);
  if (Status status = add_biases(settings, steps); !status.ok()) return status;
  steps.add({.kind = UsbStepKind::kTransfers});
  steps.add(kStart);
  return {};
}

void add_stop(UsbSteps& steps) noexcept {
  steps.add(kStop);
}

constexpr UsbCameraDriver kDriver{.family = "EVK3/EVK4",
                                  .is_inivation = false,
                                  .endpoint = 0x81,
                                  .transfers = 20,
                                  .transfer_bytes = 128 * 1024,
                                  .transfer_timeout_ms = 100,
                                  .is_drained = true,
                                  .identify = identify,
                                  .add_start = add_start,
                                  .add_stop = add_stop,
                                  .write = treuzell_write,
                                  .read = treuzell_read,
                                  .pulse = nullptr,
                                  .read_dropped = nullptr};

}  // namespace

const UsbCameraDriver& imx636_driver() noexcept {
  return kDriver;
}

}  // namespace egofocus
