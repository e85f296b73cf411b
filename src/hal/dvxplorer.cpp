// DVXplorer and DVXplorer Lite with FPGA and FX3. Sources: libcaer, src/dvxplorer.c and
// include/libcaer/devices/dvxplorer.h.
#include "hal/inivation_logic.hpp"
#include "hal/usb_camera.hpp"

namespace egofocus {
namespace {

constexpr std::uint16_t kChipMode = 0x3000;
constexpr std::uint32_t kStream = 2;
constexpr std::uint16_t kTimeReset = 0x3238;

struct Register {
  std::uint16_t address;
  std::uint8_t value;
};

constexpr Register kBiasCommon[] = {{0x000D, 0x24}, {0x000F, 0x07}, {0x0010, 0xFF}, {0x0013, 0x03},
                                    {0x0014, 0x7F}, {0x0015, 0x00}, {0x0018, 0x04}, {0x000C, 0x14}};

// Rows by UsbSensitivity: 000B, 0012, 001C (ON), 001E (OFF).
constexpr std::uint8_t kPresets[5][4] = {{0x06, 0x7D, 0x06, 0x02},
                                         {0x06, 0x7D, 0x03, 0x05},
                                         {0x06, 0x7D, 0x00, 0x08},
                                         {0x04, 0x7F, 0x05, 0x03},
                                         {0x04, 0x7F, 0x02, 0x06}};
constexpr std::uint16_t kPresetRegisters[4] = {0x000B, 0x0012, 0x001C, 0x001E};

constexpr Register kReadOut[] = {
    {0x3011, 0xA0},                  // system clock divided
    {0x3019, 0x00}, {0x301E, 0x01},  // parallel output
    {0x3067, 0x80},                  // groups of rows in one word
    {0x3255, 0x0C}, {0x3266, 0x08},  // row and column signals, boot sequence
    {0x3235, 0x03}, {0x3236, 0xE7},  // time unit: 999, 1 ms
    {0x3234, 49},                    // its part: clock of 50 MHz
    {0x323D, 50},   {0x3243, 50},   {0x3247, 50}, {0x3259, 50}, {0x3600, 0x01},  // histogram off
    {0x3240, 0},    {0x3241, 0},    {0x3242, 2},  // GH count 2 us: ms, then us in two bytes
    {0x3244, 0},    {0x3245, 0},    {0x3246, 0},  // GRS count 0 us
    {0x3256, 0},    {0x3257, 0},    {0x3258, 1},  // GRS end 1 us
    {0x323C, 4},    {0x324C, 6},    {0x324E, 4},  {0x324F, 6},  {0x3253, 8},    {0x3254, 10},
    {0x3261, 0},    {0x3262, 15},   {0x3251, 10}, {0x324B, 4},  {0x325D, 0xAF}, {0x325E, 0xC8},  // 45000
    {0x3300, 1},  // no cropping
    {0x3500, 1},  // no activity decision
};

Status identify(UsbConnection& usb, UsbCameraInfo& info) noexcept {
  info.name = "DVXplorer";
  return identify_inivation(InivationFormat::kDvxplorer, 2, 8, usb, info);
}

void add_chip(UsbSensitivity sensitivity, UsbSteps& steps) noexcept {
  for (const Register& r : kBiasCommon) steps.write(inivation_address(kBias, r.address), r.value);
  for (std::size_t i = 0; i < 4; ++i) {
    steps.write(inivation_address(kBias, kPresetRegisters[i]),
                kPresets[static_cast<std::size_t>(sensitivity)][i]);
  }
  for (const Register& r : kReadOut) steps.write(inivation_address(kBias, r.address), r.value);
}

Status add_start(const UsbCameraSettings& settings, const UsbCameraInfo& info, UsbSteps& steps) noexcept {
  if (settings.bias_count > 0) {
    return {StatusCode::kBadDeviceSetting, "biases of a DVXplorer: it has `sensitivity` instead",
            static_cast<std::int64_t>(settings.bias_count)};
  }
  add_inivation_off(steps);
  steps.wait(10'000);
  steps.write(inivation_address(kMux, kMuxRunChip), 1);
  steps.wait(10'000);
  add_chip(settings.sensitivity, steps);
  add_inivation_drop_policy(steps);
  add_inivation_early_packet(info, steps);
  steps.add({.kind = UsbStepKind::kTransfers});
  add_inivation_stream(info, steps);
  add_inivation_sensors(settings, steps);
  steps.write(inivation_address(kBias, kTimeReset), 1);
  steps.write(inivation_address(kBias, kTimeReset), 0);
  steps.write(inivation_address(kBias, kChipMode), kStream);
  return {};
}

void add_stop(UsbSteps& steps) noexcept {
  steps.write(inivation_address(kBias, kChipMode), 0);
  add_inivation_off(steps);
}

constexpr UsbCameraDriver kDriver{.family = "DVXplorer",
                                  .is_inivation = true,
                                  .endpoint = 0x82,
                                  .transfers = 16,
                                  .transfer_bytes = 16384,
                                  .transfer_timeout_ms = 0,
                                  .is_drained = false,
                                  .identify = identify,
                                  .add_start = add_start,
                                  .add_stop = add_stop,
                                  .write = inivation_write,
                                  .read = inivation_read,
                                  .pulse = inivation_pulse,
                                  .read_dropped = read_inivation_dropped};

}  // namespace

const UsbCameraDriver& dvxplorer_driver() noexcept {
  return kDriver;
}

}  // namespace egofocus
