// Event sensors behind V4L2: what can be set, what a found one tells, how it is opened.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/status.hpp"
#include "hal/raw_header.hpp"
#include "hal/v4l2_controls.hpp"
#include "hal/v4l2_file.hpp"
#include "hal/v4l2_media.hpp"

namespace egofocus {

/// A control of the sensor or of the video node, by the name that `v4l2-ctl -l` prints: bias_fo, erc_rate ...
struct V4l2ControlSetting {
  char name[32] = {};
  std::int64_t value = 0;
};

/// How much of a buffer is valid.
enum class V4l2FrameEnd : std::uint8_t {
  /// kMarker where the format is disguised or the sensor's control enable_end_of_frame_marker is on, else
  /// kBytesUsed.
  kAuto,
  kBytesUsed,  ///< what the receiver says; words go on in the next buffer
  kMarker,     ///< up to the sensor's end-of-frame marker; a sensor that can is told to send the 64-bit one
};

struct V4l2CameraSettings {
  static constexpr std::size_t kMaxControls = 32;
  /// "/dev/video0", or the beginning of the sensor's entity ("genx320", "imx636 10-003c"); empty: the only
  /// event sensor there is.
  char device[64] = {};
  bool has_format = false;  ///< `format` is given; one that the device contradicts is refused
  EvtFormat format = EvtFormat::kEvt3;
  SensorSize size;  ///< 0 x 0: as the sensor says
  V4l2FrameEnd frame_end = V4l2FrameEnd::kAuto;
  bool decode_unmarked = false;  ///< kMarker: a buffer without marker is decoded as a whole, not refused
  std::int32_t buffers = 16;     ///< asked of the driver, 2..32
  std::int32_t frame_bytes = 4 << 20;  ///< largest buffer that is taken, 4096..64 MiB
  std::int32_t silence_ms = 1000;      ///< without a buffer for so long the stream is lost; 0: never
  bool reopen = true;        ///< a lost device is opened again by poll(); false: poll() returns kDeviceLost
  bool device_time = false;  ///< events keep the sensor's time, for ClockKind::kDevice; else the host's
  V4l2ControlSetting controls[kMaxControls];
  std::size_t control_count = 0;
};

/// What was read from an opened device.
struct V4l2CameraInfo {
  static constexpr std::size_t kMaxControls = 64;
  V4l2Route route;  ///< a node without a known sensor: video_path alone
  char driver[16] = {};
  char card[32] = {};
  bool is_multiplanar = false;
  std::uint32_t fourcc = 0;
  EvtFormat format = EvtFormat::kEvt3;
  SensorSize size;
  std::size_t frame_bytes = 0;  ///< of one buffer
  bool has_marker = false;      ///< buffers are cut at the marker
  V4l2Control controls[kMaxControls];
  std::size_t control_count = 0;  ///< the sensor's, then the video node's
  std::size_t sensor_control_count = 0;
  [[nodiscard]] std::span<const V4l2Control> all_controls() const noexcept {
    return {controls, control_count};
  }
};

/// The ranges that every setting must lie in, whatever device there is. kBadDeviceSetting. Thread: any. RT:
/// yes.
Status check_v4l2_settings(const V4l2CameraSettings& settings) noexcept;

/// Finds and opens the video node, decides encoding, geometry and frame end, sets the controls. Formats and
/// media links stay as they are: see docs/v4l2.md. Errors: kBadDeviceSetting (see
/// describe_refused_control()), kNoDevice, kAmbiguousDevice, kNoPermission, kUnsupportedDevice, kDeviceBusy,
/// kDeviceLost, kIo. Thread: one. RT: no.
Status open_v4l2_camera(const V4l2CameraSettings& settings, V4l2File& node, V4l2CameraInfo& info) noexcept;

/// The steps of open_v4l2_camera() that the list of devices takes as well. Thread: one. RT: no.
Status read_v4l2_format(V4l2File& node, V4l2CameraInfo& info) noexcept;
/// Of Prophesee's fourcc codes; false for another one. Source: prophesee-ai/linux-sensor-drivers,
/// psee-format.h. Thread: any. RT: yes.
bool evt_format_of(std::uint32_t fourcc, EvtFormat& format) noexcept;
/// 8 or 16 bits a pixel without a meaning: what a receiver calls event data that it has no code for. Thread:
/// any. RT: yes.
bool is_disguise(std::uint32_t fourcc) noexcept;

/// Encoding, geometry, frame end and controls, from the sensor as far as there is one (v4l2_sensor.cpp).
Status read_v4l2_sensor(const V4l2CameraSettings& settings, const V4l2File& node,
                        V4l2CameraInfo& info) noexcept;

/// One line about a control that was refused (kBadDeviceSetting): which, why, and the names that exist. Empty
/// when the controls are fine. Returns the characters written; a final NUL always. Thread: any. RT: yes.
std::size_t describe_refused_control(const V4l2CameraSettings& settings, const V4l2CameraInfo& info,
                                     std::span<char> out) noexcept;

}  // namespace egofocus
