// Event cameras on USB: which there are, what can be set, what a driver of one knows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/status.hpp"
#include "hal/axis_map.hpp"
#include "hal/inivation_decoder.hpp"
#include "hal/usb_connection.hpp"
#include "hal/usb_steps.hpp"

namespace egofocus {

/// A bias by the name that its data sheet uses. DAVIS: `coarse` 0..7 and `fine` 0..255. IMX636: `offset` to
/// the factory's value.
struct UsbBias {
  char name[20] = {};
  std::int32_t coarse = -1;  ///< -1: not given
  std::int32_t fine = -1;    ///< -1: not given
  std::int32_t offset = 0;
};

/// DVXplorer: contrast sensitivity as its maker's presets.
enum class UsbSensitivity : std::uint8_t { kVeryLow, kLow, kDefault, kHigh, kVeryHigh };

struct UsbCameraSettings {
  static constexpr std::size_t kMaxBiases = 32;
  char serial[24] = {};             ///< empty: the only camera there is
  std::int32_t transfers = 0;       ///< in flight, 2..64; 0: as the camera's family has it
  std::int32_t transfer_bytes = 0;  ///< of each, 1024..1048576, a multiple of 1024; 0: likewise
  bool imu = false;                 ///< iniVation: the camera's IMU is a motion source
  AxisMap imu_axes;                 ///< from the camera's IMU to the body
  bool background_filter = false;   ///< DAVIS: the camera drops isolated events by itself, uncounted by us
  UsbSensitivity sensitivity = UsbSensitivity::kDefault;  ///< DVXplorer
  bool reopen = true;        ///< a lost camera is opened again by poll(); false: poll() returns kDeviceLost
  bool device_time = false;  ///< samples keep the camera's time, for ClockKind::kDevice; else the host's
  UsbBias biases[kMaxBiases];
  std::size_t bias_count = 0;
};

/// What was read from an opened camera.
struct UsbCameraInfo {
  UsbDevice device;
  const char* name = "";       ///< of the model; "" before it is known
  char serial[24] = {};        ///< "" where there is none
  std::uint32_t logic = 0;     ///< version of the FPGA's logic; Prophesee: of the firmware, 0x00MMmmpp
  std::uint32_t patch = 0;     ///< iniVation
  std::uint32_t firmware = 0;  ///< of the USB controller
  SensorSize size;
  std::uint32_t chip = 0;
  std::uint32_t usb_clock_khz = 0;  ///< iniVation: true clock of the early-packet timer
  bool is_clock_master = true;
  bool has_statistics = false;  ///< counts what it dropped
  bool has_pixel_filter = false;
  bool has_background_filter = false;
  InivationLayout layout;  ///< iniVation
};

/// One family of cameras. Functions return 0 or an errno, or a Status where a user can do something.
struct UsbCameraDriver {
  const char* family = "";
  bool is_inivation = false;  ///< InivationDecoder; else EVT3
  std::uint8_t endpoint = 0;  ///< of the data
  std::int32_t transfers = 0;
  std::int32_t transfer_bytes = 0;
  unsigned transfer_timeout_ms = 0;  ///< 0: none; the camera sends short packets by itself
  bool is_drained = false;           ///< old data are read away before the start

  /// Reads versions and sizes. kUnknownFirmware, kUnsupportedDevice, kDeviceLost.
  Status (*identify)(UsbConnection& usb, UsbCameraInfo& info) noexcept = nullptr;
  /// Appends configuration and start. kBadDeviceSetting.
  Status (*add_start)(const UsbCameraSettings& settings, const UsbCameraInfo& info,
                      UsbSteps& steps) noexcept = nullptr;
  void (*add_stop)(UsbSteps& steps) noexcept = nullptr;

  int (*write)(UsbConnection& usb, std::uint32_t address, std::uint32_t value) noexcept = nullptr;
  int (*read)(UsbConnection& usb, std::uint32_t address, std::uint32_t& value) noexcept = nullptr;
  int (*pulse)(UsbConnection& usb, std::uint32_t address) noexcept = nullptr;
  /// Events that the camera dropped since it was started; nullptr: the stream itself tells.
  int (*read_dropped)(UsbConnection& usb, std::uint64_t& events) noexcept = nullptr;
};

const UsbCameraDriver& davis_driver() noexcept;
const UsbCameraDriver& dvxplorer_driver() noexcept;
const UsbCameraDriver& imx636_driver() noexcept;

/// The driver for a device, or nullptr. `why_not` becomes "" for what is no event camera at all, and a reason
/// for one that is known and cannot be driven. Thread: any. RT: yes.
const UsbCameraDriver* driver_of(const UsbDevice& device, const char*& why_not) noexcept;

/// Opens, claims and identifies one camera of an open bus; fills in what it gets to know on the way.
/// kNoPermission, kDeviceBusy, kDeviceLost and those of identify. Thread: one. RT: no.
Status open_camera(UsbConnection& usb, const UsbDevice& device, const UsbCameraDriver& driver,
                   UsbCameraInfo& info) noexcept;

/// True when a device made for USB 3 hangs on a slower link: enough for a quiet scene only. Thread: any. RT:
/// yes.
bool is_slow_link(const UsbDevice& device) noexcept;

}  // namespace egofocus
