// What the sensor's sub-device tells and takes: encoding, geometry, controls.
#include <linux/v4l2-subdev.h>
#include <linux/videodev2.h>

#include <string_view>

#include "hal/device_status.hpp"
#include "hal/v4l2_camera.hpp"
#include "hal/v4l2_text.hpp"

namespace egofocus {
namespace {

constexpr std::int64_t kMarker64 = 3;  // of the menu enable_end_of_frame_marker: 64 bits, without a time base
constexpr std::int64_t kMostPixels = 2048;

// linux-sensor-drivers: menu "evt_format", EVT2, EVT21, EVT3, and EVT21ME on an IMX636.
bool format_named(std::string_view name, EvtFormat& format) noexcept {
  constexpr struct {
    std::string_view name;
    EvtFormat format;
  } kNames[] = {{"evt2", EvtFormat::kEvt2},           {"evt2_0", EvtFormat::kEvt2},
                {"evt21", EvtFormat::kEvt21},         {"evt2_1", EvtFormat::kEvt21},
                {"evt21me", EvtFormat::kEvt21Legacy}, {"evt3", EvtFormat::kEvt3},
                {"evt3_0", EvtFormat::kEvt3}};
  for (const auto& known : kNames) {
    if (known.name != name) continue;
    format = known.format;
    return true;
  }
  return false;
}

bool sensor_says(const V4l2File& sensor, std::span<const V4l2Control> controls, EvtFormat& format) noexcept {
  const V4l2Control* const control = find_control(controls, "evt_format");
  std::int64_t index = 0;
  char name[32];
  return control != nullptr && read_control(sensor, *control, index) == 0 &&
         read_menu_text(sensor, *control, index, name) == 0 && format_named(name, format);
}

// The fourcc knows best, then the sensor, then the settings; who contradicts is refused, not corrected.
Status decide_format(const V4l2CameraSettings& settings, const V4l2File& sensor,
                     std::span<const V4l2Control> controls, V4l2CameraInfo& info) noexcept {
  const bool is_told = evt_format_of(info.fourcc, info.format) ||
                       (sensor.is_open() && sensor_says(sensor, controls, info.format));
  if (is_told && settings.has_format && settings.format != info.format) {
    return {StatusCode::kBadDeviceSetting, "format: the device says that it sends another one",
            static_cast<std::int64_t>(settings.format), static_cast<std::int64_t>(info.format)};
  }
  if (is_told) return {};
  if (!settings.has_format) {
    return {StatusCode::kBadDeviceSetting,
            "format: neither the fourcc nor a control evt_format tells the encoding, so it must be set",
            info.fourcc};
  }
  info.format = settings.format;
  return {};
}

bool is_size(std::int64_t width, std::int64_t height) noexcept {
  return width >= 8 && width <= kMostPixels && height >= 8 && height <= kMostPixels;
}

// Width and height of the format are packets, not pixels: the selection rectangles are the sensor's own.
bool selection_of(const V4l2File& sensor, std::uint32_t target, SensorSize& size) noexcept {
  v4l2_subdev_selection selection{};
  selection.which = V4L2_SUBDEV_FORMAT_ACTIVE;
  selection.target = target;
  if (sensor.ioctl(VIDIOC_SUBDEV_G_SELECTION, selection) < 0) return false;
  if (!is_size(selection.r.width, selection.r.height)) return false;
  size = {static_cast<std::uint16_t>(selection.r.width), static_cast<std::uint16_t>(selection.r.height)};
  return true;
}

Status decide_size(const V4l2CameraSettings& settings, const V4l2File& sensor,
                   V4l2CameraInfo& info) noexcept {
  const std::string_view model = sensor_model(info.route.sensor);
  const bool is_told = sensor.is_open() && (selection_of(sensor, V4L2_SEL_TGT_NATIVE_SIZE, info.size) ||
                                            selection_of(sensor, V4L2_SEL_TGT_CROP_BOUNDS, info.size));
  if (!is_told && model == "imx636") info.size = {1280, 720};
  if (!is_told && model == "genx320") info.size = {320, 320};
  const SensorSize wanted = settings.size;
  if (info.size.width_px == 0) info.size = wanted;
  if (info.size.width_px == 0)
    return {StatusCode::kBadDeviceSetting, "size: no sensor tells it, so width and height must be set"};
  if (wanted.width_px != 0 &&
      (wanted.width_px != info.size.width_px || wanted.height_px != info.size.height_px)) {
    return {StatusCode::kBadDeviceSetting, "size: the sensor has another width or height", wanted.width_px,
            info.size.width_px};
  }
  return {};
}

// Why a setting cannot be written; "" when it can.
const char* obstacle(const V4l2Control* control, std::int64_t value) noexcept {
  if (control == nullptr) return "there is no control of this name";
  if ((control->flags & V4L2_CTRL_FLAG_READ_ONLY) != 0) return "it can only be read";
  if (value < control->minimum || value > control->maximum) return "the value is out of its range";
  return "";
}

Status write_controls(const V4l2CameraSettings& settings, const V4l2File& sensor, const V4l2File& node,
                      const V4l2CameraInfo& info) noexcept {
  for (std::size_t i = 0; i < settings.control_count; ++i) {
    const V4l2ControlSetting& wanted = settings.controls[i];
    const V4l2Control* const control = find_control(info.all_controls(), wanted.name);
    if (const char* const why = obstacle(control, wanted.value); why[0] != '\0')
      return {StatusCode::kBadDeviceSetting, why, wanted.value, static_cast<std::int64_t>(i)};
  }
  for (std::size_t i = 0; i < settings.control_count; ++i) {
    const V4l2ControlSetting& wanted = settings.controls[i];
    const V4l2Control& control = *find_control(info.all_controls(), wanted.name);
    const bool is_of_sensor = &control < info.controls + info.sensor_control_count;
    if (const int code = write_control(is_of_sensor ? sensor : node, control, wanted.value); code < 0)
      return device_status(-code, "writing a V4L2 control");
  }
  return {};
}

// A receiver that needs the marker gets it, if the sensor can send one and nobody asked for another kind.
Status decide_frame_end(const V4l2CameraSettings& settings, const V4l2File& sensor,
                        std::span<const V4l2Control> controls, V4l2CameraInfo& info) noexcept {
  const V4l2Control* const control = find_control(controls, "enable_end_of_frame_marker");
  std::int64_t kind = 0;
  const bool is_readable = control != nullptr && read_control(sensor, *control, kind) == 0;
  info.has_marker = settings.frame_end == V4l2FrameEnd::kMarker ||
                    (settings.frame_end == V4l2FrameEnd::kAuto && (is_disguise(info.fourcc) || kind != 0));
  if (!info.has_marker || !is_readable || kind != 0) return {};
  return device_status(-write_control(sensor, *control, kMarker64), "the control enable_end_of_frame_marker");
}

}  // namespace

Status read_v4l2_sensor(const V4l2CameraSettings& settings, const V4l2File& node,
                        V4l2CameraInfo& info) noexcept {
  V4l2File sensor(node.io());
  if (info.route.sensor_path[0] != '\0') {
    if (const int code = sensor.open(info.route.sensor_path); code < 0)
      return device_status(-code, "the sub-device of the sensor (/dev/v4l-subdev*)");
  }
  constexpr std::size_t kMost = V4l2CameraInfo::kMaxControls;
  const auto lower_of = [](std::size_t a, std::size_t b) noexcept { return a < b ? a : b; };
  if (sensor.is_open()) info.sensor_control_count = lower_of(list_controls(sensor, info.controls), kMost);
  const std::span<V4l2Control> room = std::span(info.controls).subspan(info.sensor_control_count);
  info.control_count = info.sensor_control_count + lower_of(list_controls(node, room), room.size());

  const std::span<const V4l2Control> of_sensor = info.all_controls().first(info.sensor_control_count);
  Status status = write_controls(settings, sensor, node, info);
  if (status.ok()) status = decide_format(settings, sensor, of_sensor, info);
  if (status.ok()) status = decide_size(settings, sensor, info);
  if (status.ok()) status = decide_frame_end(settings, sensor, of_sensor, info);
  return status;
}

std::size_t describe_refused_control(const V4l2CameraSettings& settings, const V4l2CameraInfo& info,
                                     std::span<char> out) noexcept {
  V4l2Text line(out);
  for (std::size_t i = 0; i < settings.control_count && i < V4l2CameraSettings::kMaxControls; ++i) {
    const V4l2ControlSetting& wanted = settings.controls[i];
    const V4l2Control* const control = find_control(info.all_controls(), wanted.name);
    const char* const why = obstacle(control, wanted.value);
    if (why[0] == '\0') continue;
    line.text("control '").text(wanted.name).text("': ").text(why);
    if (control != nullptr) {
      line.text(", ").number(control->minimum).text(" .. ").number(control->maximum);
      break;
    }
    line.text("; there are:");
    for (const V4l2Control& known : info.all_controls()) line.text(" ").text(known.name);
    if (info.control_count == 0) line.text(" none");
    break;
  }
  return line.size();
}

}  // namespace egofocus
