// DAVIS346 and DAVIS240. Sources: libcaer, src/davis.c, src/davis_common.h and
// include/libcaer/devices/davis.h.
#include "hal/davis_biases.hpp"
#include "hal/device_status.hpp"
#include "hal/inivation_logic.hpp"
#include "hal/usb_camera.hpp"

namespace egofocus {
namespace {

constexpr std::uint16_t kFx2 = 0x841B;
constexpr std::uint32_t kPixelFilters = 8;
constexpr std::uint32_t kBackgroundTime = 8;  // of 250 us

enum Parameter : std::uint16_t {
  kDvsWaitOnStall = 4,
  kDvsExternalAer = 5,
  kDvsHasPixelFilter = 10,
  kDvsPixelRow0 = 11,
  kDvsHasBackgroundFilter = 30,
  kDvsBackgroundFilter = 31,
  kDvsBackgroundTime = 32,
  kDvsRefractoryFilter = 33,
  kDvsFirstColumn = 41,
  kDvsFirstRow = 42,
  kDvsLastColumn = 43,
  kDvsLastRow = 44,
  kDvsSkipFilter = 51,
  kDvsFlattenPolarity = 61,
  kDvsSuppressPolarity = 62,
  kApsRun = 4,
  kApsGlobalShutter = 7,
  kImuRateDivider = 5,
  kImuAccelLowPass = 6,
  kImuAccelRange = 7,
  kImuGyroLowPass = 9,
  kImuGyroRange = 10,
};

bool is_240(std::uint32_t chip) noexcept {
  return chip <= 2;
}
bool is_346(std::uint32_t chip) noexcept {
  return chip == 4 || chip == 5 || chip == 9;
}

Status identify(UsbConnection& usb, UsbCameraInfo& info) noexcept {
  const bool is_fx2 = info.device.product == kFx2;
  if (Status status = identify_inivation(InivationFormat::kDavis, 1, is_fx2 ? 4 : 6, usb, info); !status.ok())
    return status;
  if (is_240(info.chip)) {
    info.name = "DAVIS240";
  } else if (is_346(info.chip)) {
    info.name = "DAVIS346";
  } else {
    return {StatusCode::kUnsupportedDevice, "a DAVIS whose chip is neither the 240 nor the 346", info.chip};
  }
  std::uint32_t filter = 0;
  int error = inivation_read(usb, inivation_address(kDvs, kDvsHasPixelFilter), filter);
  info.has_pixel_filter = filter != 0;
  if (error == 0) error = inivation_read(usb, inivation_address(kDvs, kDvsHasBackgroundFilter), filter);
  info.has_background_filter = filter != 0;
  return device_status(error, info.name);
}

void add_chip(std::uint32_t chip, UsbSteps& steps) noexcept {
  constexpr std::uint16_t kResetCalibrationNeuron = 136;
  constexpr std::uint16_t kResetTestPixel = 138;
  constexpr std::uint16_t kSpecialPixel = 139;
  constexpr std::uint16_t kGlobalShutter = 142;
  constexpr std::uint16_t kGreyCounter = 143;
  constexpr std::uint16_t kTestAdc = 144;
  for (std::uint16_t parameter = 128; parameter <= kGlobalShutter; ++parameter) {
    if (parameter == kSpecialPixel && (!is_240(chip) || chip == 2)) continue;
    const bool is_set = parameter == kResetCalibrationNeuron || parameter == kResetTestPixel;
    steps.write(inivation_address(kBias, parameter), is_set ? 1 : 0);
  }
  if (!is_346(chip)) return;
  steps.write(inivation_address(kBias, kGreyCounter), 1);
  steps.write(inivation_address(kBias, kTestAdc), 0);
}

void add_pixels(const UsbCameraSettings& settings, const UsbCameraInfo& info, UsbSteps& steps) noexcept {
  const std::uint32_t columns = info.layout.sent.width_px;
  const std::uint32_t rows = info.layout.sent.height_px;
  const auto dvs = [&steps](std::uint16_t parameter, std::uint32_t value) {
    steps.write(inivation_address(kDvs, parameter), value);
  };
  dvs(kDvsWaitOnStall, 0);
  dvs(kDvsExternalAer, 0);
  for (std::uint16_t k = 0; info.has_pixel_filter && k < 2 * kPixelFilters; ++k) {
    dvs(static_cast<std::uint16_t>(kDvsPixelRow0 + k), k % 2 == 0 ? rows : columns);  // outside: off
  }
  if (info.has_background_filter) {
    dvs(kDvsBackgroundFilter, settings.background_filter ? 1 : 0);
    dvs(kDvsBackgroundTime, kBackgroundTime);
    dvs(kDvsRefractoryFilter, 0);
  }
  dvs(kDvsFirstColumn, 0);
  dvs(kDvsFirstRow, 0);
  dvs(kDvsLastColumn, columns - 1);
  dvs(kDvsLastRow, rows - 1);
  dvs(kDvsSkipFilter, 0);
  dvs(kDvsFlattenPolarity, 0);
  dvs(kDvsSuppressPolarity, 0);
}

// 1 kHz, +-4 g, +-500 deg/s.
void add_imu(UsbSteps& steps) noexcept {
  steps.write(inivation_address(kImu, kImuRateDivider), 0);
  steps.write(inivation_address(kImu, kImuAccelLowPass), 1);
  steps.write(inivation_address(kImu, kImuAccelRange), 1);
  steps.write(inivation_address(kImu, kImuGyroLowPass), 1);
  steps.write(inivation_address(kImu, kImuGyroRange), 1);
}

Status add_start(const UsbCameraSettings& settings, const UsbCameraInfo& info, UsbSteps& steps) noexcept {
  if (Status status = add_davis_biases(is_346(info.chip), settings, steps); !status.ok()) return status;
  add_chip(info.chip, steps);
  add_inivation_drop_policy(steps);
  add_pixels(settings, info, steps);
  steps.write(inivation_address(kAps, kApsGlobalShutter), 0);  // as in the chip's register
  add_imu(steps);
  add_inivation_early_packet(info, steps);

  add_inivation_off(steps);
  steps.write(inivation_address(kAps, kApsRun), 0);
  steps.write(inivation_address(kMux, kMuxRunChip), 0);
  steps.wait(10'000);  // the camera's queues run empty
  steps.add({.kind = UsbStepKind::kTransfers});
  steps.write(inivation_address(kMux, kMuxRunChip), 1);
  steps.wait(200'000);  // the biases settle
  add_inivation_stream(info, steps);
  add_inivation_sensors(settings, steps);
  return {};
}

void add_stop(UsbSteps& steps) noexcept {
  add_inivation_off(steps);
  steps.write(inivation_address(kMux, kMuxRunChip), 0);
}

constexpr UsbCameraDriver kDriver{.family = "DAVIS",
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

const UsbCameraDriver& davis_driver() noexcept {
  return kDriver;
}

}  // namespace egofocus
