// UsbCameraSource: settings, and how the camera that is meant is found among all devices.
#include <array>
#include <string_view>

#include "hal/device_status.hpp"
#include "hal/usb_camera_source.hpp"

namespace egofocus {
namespace {

constexpr std::size_t kMostDevices = 128;

std::size_t transfers_of(const UsbCameraSettings& settings, const UsbCameraDriver& driver) noexcept {
  return static_cast<std::size_t>(settings.transfers == 0 ? driver.transfers : settings.transfers);
}
std::size_t bytes_of(const UsbCameraSettings& settings, const UsbCameraDriver& driver) noexcept {
  return static_cast<std::size_t>(settings.transfer_bytes == 0 ? driver.transfer_bytes
                                                               : settings.transfer_bytes);
}

void copy(const char* from, std::span<char> to) noexcept {
  std::size_t i = 0;
  for (; i + 1 < to.size() && from[i] != '\0'; ++i) to[i] = from[i];
  to[i] = '\0';
}

}  // namespace

Status check_usb_settings(const UsbCameraSettings& settings) noexcept {
  if (settings.transfers != 0 && (settings.transfers < 2 || settings.transfers > 64))
    return {StatusCode::kBadDeviceSetting, "transfers, 2..64 or 0", settings.transfers};
  const std::int32_t bytes = settings.transfer_bytes;
  if (bytes != 0 && (bytes < 1024 || bytes > (1 << 20) || bytes % 1024 != 0))
    return {StatusCode::kBadDeviceSetting, "transfer_bytes, 1024..1048576 by 1024, or 0", bytes};
  if (!is_permutation(settings.imu_axes))
    return {StatusCode::kBadDeviceSetting, "imu_axes, a signed permutation of x y z",
            settings.imu_axes.from[0]};
  if (settings.bias_count > UsbCameraSettings::kMaxBiases)
    return {StatusCode::kBadDeviceSetting, "number of biases",
            static_cast<std::int64_t>(settings.bias_count)};
  return {};
}

std::size_t UsbCameraSource::buffer_bytes(const UsbCameraSettings& settings) noexcept {
  std::size_t most = 0;
  for (const UsbCameraDriver* driver : {&davis_driver(), &dvxplorer_driver(), &imx636_driver()}) {
    const std::size_t bytes = transfers_of(settings, *driver) * bytes_of(settings, *driver);
    if (bytes > most) most = bytes;
  }
  return most;
}

Status UsbCameraSource::open() noexcept {
  if (Status status = check_usb_settings(settings_); !status.ok()) return status;
  if (buffers_.size() < buffer_bytes(settings_)) {
    return {StatusCode::kArenaTooSmall, "buffers of the USB camera",
            static_cast<std::int64_t>(buffers_.size()), static_cast<std::int64_t>(buffer_bytes(settings_))};
  }
  close();
  Status status = device_status(usb_.open_bus(io_), "the USB bus");
  if (status.ok()) status = find();
  if (status.ok()) {
    const int error =
        transfers_.prepare(usb_, buffers_, transfers_of(settings_, *driver_), bytes_of(settings_, *driver_));
    status = device_status(error, "memory for USB transfers");
  }
  if (!status.ok()) {
    close();
    return status;
  }
  ++counts_.opened;
  copy(info_.serial, known_serial_);
  return {};
}

Status UsbCameraSource::find() noexcept {
  std::array<UsbDevice, kMostDevices> devices;
  const std::size_t found = usb_.list(devices);
  std::size_t cameras = 0;
  for (std::size_t i = 0; i < found && i < devices.size(); ++i) {
    const char* why_not = "";
    if (driver_of(devices[i], why_not) != nullptr) devices[cameras++] = devices[i];
  }
  const std::span<const UsbDevice> candidates = std::span(devices).first(cameras);
  if (candidates.empty())
    return {StatusCode::kNoDevice, "an event camera on USB that this library drives", 0};
  if (settings_.serial[0] != '\0' || known_serial_[0] != '\0') return open_matching(candidates);
  if (candidates.size() > 1)
    return {StatusCode::kAmbiguousDevice, "event cameras on USB",
            static_cast<std::int64_t>(candidates.size())};
  info_ = {};
  const char* why_not = "";
  driver_ = driver_of(candidates[0], why_not);
  return open_camera(usb_, candidates[0], *driver_, info_);
}

// A camera tells its serial number only when it is open. The first that could not be opened explains why none
// matched.
Status UsbCameraSource::open_matching(std::span<const UsbDevice> candidates) noexcept {
  const std::string_view wanted = settings_.serial[0] != '\0' ? settings_.serial : known_serial_;
  Status obstacle;
  for (const UsbDevice& device : candidates) {
    info_ = {};
    const char* why_not = "";
    driver_ = driver_of(device, why_not);
    const Status status = open_camera(usb_, device, *driver_, info_);
    if (wanted == info_.serial) return status;
    if (obstacle.ok() && !status.ok() && info_.serial[0] == '\0') obstacle = status;
    usb_.close_device();
  }
  if (!obstacle.ok()) return obstacle;
  return {StatusCode::kNoDevice, "an event camera with the wanted serial number",
          static_cast<std::int64_t>(candidates.size())};
}

}  // namespace egofocus
