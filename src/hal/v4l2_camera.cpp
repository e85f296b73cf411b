#include "hal/v4l2_camera.hpp"

#include <linux/videodev2.h>

#include <string_view>

#include "hal/device_status.hpp"
#include "hal/v4l2_text.hpp"

namespace egofocus {
namespace {

constexpr std::uint32_t kPsee = v4l2_fourcc('P', 'S', 'E', 'E');
constexpr std::uint32_t kPse1 = v4l2_fourcc('P', 'S', 'E', '1');
constexpr std::uint32_t kPse2 = v4l2_fourcc('P', 'S', 'E', '2');
constexpr std::uint32_t kPse3 = v4l2_fourcc('P', 'S', 'E', '3');
constexpr std::int32_t kMostFrameBytes = 64 << 20;

bool is_between(std::int64_t value, std::int64_t low, std::int64_t high) noexcept {
  return low <= value && value <= high;
}

Status open_path(const char* path, V4l2File& node) noexcept {
  const int code = node.open(path);
  if (code == -ENOENT) return {StatusCode::kNoDevice, "the video node that `device` names", 0};
  return device_status(-code, "the video node");
}

Status find_by_path(const V4l2CameraSettings& settings, const V4l2Routes& routes, V4l2File& node,
                    V4l2CameraInfo& info) noexcept {
  if (const Status status = open_path(settings.device, node); !status.ok()) return status;
  V4l2Text(info.route.video_path).text(settings.device);
  std::uint32_t major = 0;
  std::uint32_t minor = 0;
  if (node.number(major, minor) < 0) return {};
  for (const V4l2Route& route : routes.all()) {
    if (route.video_path[0] != '\0' && route.video_major == major && route.video_minor == minor)
      info.route = route;
  }
  return {};
}

Status find_by_sensor(const V4l2CameraSettings& settings, const V4l2Routes& routes, V4l2File& node,
                      V4l2CameraInfo& info) noexcept {
  std::int64_t fitting = 0;
  for (const V4l2Route& route : routes.all()) {
    if (!std::string_view(route.sensor).starts_with(settings.device)) continue;
    info.route = route;
    ++fitting;
  }
  if (fitting == 0 && routes.forbidden > 0)
    return {StatusCode::kNoPermission, "media devices (/dev/media*)", EACCES};
  if (fitting == 0)
    return {StatusCode::kNoDevice, "an event sensor of a media device",
            static_cast<std::int64_t>(routes.count)};
  if (fitting > 1) return {StatusCode::kAmbiguousDevice, "event sensors of media devices", fitting};
  if (info.route.video_path[0] == '\0')
    return {StatusCode::kNoDevice,
            "a video node behind the sensor: its media links are not set up, see docs/v4l2.md", 0};
  return open_path(info.route.video_path, node);
}

}  // namespace

bool evt_format_of(std::uint32_t fourcc, EvtFormat& format) noexcept {
  switch (fourcc) {
    case kPsee:
      format = EvtFormat::kEvt2;
      return true;
    case kPse1:
      format = EvtFormat::kEvt21Legacy;
      return true;
    case kPse2:
      format = EvtFormat::kEvt21;
      return true;
    case kPse3:
      format = EvtFormat::kEvt3;
      return true;
    default:
      return false;
  }
}

bool is_disguise(std::uint32_t fourcc) noexcept {
  switch (fourcc) {
    case V4L2_PIX_FMT_GREY:
    case V4L2_PIX_FMT_Y16:
    case V4L2_PIX_FMT_SBGGR8:
    case V4L2_PIX_FMT_SGBRG8:
    case V4L2_PIX_FMT_SGRBG8:
    case V4L2_PIX_FMT_SRGGB8:
      return true;
    default:
      return false;
  }
}

Status check_v4l2_settings(const V4l2CameraSettings& settings) noexcept {
  const auto bad = [](const char* subject, std::int64_t value) noexcept {
    return Status{StatusCode::kBadDeviceSetting, subject, value};
  };
  if (!is_between(settings.buffers, 2, VIDEO_MAX_FRAME)) return bad("buffers, 2..32", settings.buffers);
  if (!is_between(settings.frame_bytes, 4096, kMostFrameBytes))
    return bad("frame_bytes, 4096..67108864", settings.frame_bytes);
  if (!is_between(settings.silence_ms, 0, 3'600'000))
    return bad("silence_ms, 0..3600000", settings.silence_ms);
  const bool is_given = settings.size.width_px != 0 || settings.size.height_px != 0;
  if (is_given && !is_between(settings.size.width_px, 8, 2048))
    return bad("width, 8..2048", settings.size.width_px);
  if (is_given && !is_between(settings.size.height_px, 8, 2048))
    return bad("height, 8..2048", settings.size.height_px);
  if (settings.control_count > V4l2CameraSettings::kMaxControls)
    return bad("number of controls", static_cast<std::int64_t>(settings.control_count));
  return {};
}

Status read_v4l2_format(V4l2File& node, V4l2CameraInfo& info) noexcept {
  v4l2_capability capability{};
  if (node.ioctl(VIDIOC_QUERYCAP, capability) < 0)
    return {StatusCode::kUnsupportedDevice, "a node that is no V4L2 device"};
  V4l2Text(info.driver).text({reinterpret_cast<const char*>(capability.driver), sizeof info.driver - 1});
  V4l2Text(info.card).text({reinterpret_cast<const char*>(capability.card), sizeof info.card - 1});
  const std::uint32_t caps = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps
                                                                                   : capability.capabilities;
  info.is_multiplanar = (caps & V4L2_CAP_VIDEO_CAPTURE) == 0;
  if ((caps & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) == 0)
    return {StatusCode::kUnsupportedDevice, "a V4L2 node that captures nothing", caps};
  if ((caps & V4L2_CAP_STREAMING) == 0)
    return {StatusCode::kUnsupportedDevice, "a V4L2 node without streaming buffers", caps};

  v4l2_format format{};
  format.type = info.is_multiplanar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int code = node.ioctl(VIDIOC_G_FMT, format); code < 0)
    return device_status(-code, "the format of the video node");
  if (info.is_multiplanar && format.fmt.pix_mp.num_planes != 1)
    return {StatusCode::kUnsupportedDevice, "a format of several planes", format.fmt.pix_mp.num_planes};
  info.fourcc = info.is_multiplanar ? format.fmt.pix_mp.pixelformat : format.fmt.pix.pixelformat;
  info.frame_bytes =
      info.is_multiplanar ? format.fmt.pix_mp.plane_fmt[0].sizeimage : format.fmt.pix.sizeimage;
  EvtFormat ignored{};
  if (!evt_format_of(info.fourcc, ignored) && !is_disguise(info.fourcc)) {
    return {StatusCode::kUnsupportedDevice,
            "a pixel format that cannot carry events; docs/v4l2.md says how to set it up", info.fourcc};
  }
  return {};
}

Status open_v4l2_camera(const V4l2CameraSettings& settings, V4l2File& node, V4l2CameraInfo& info) noexcept {
  info = {};
  if (const Status status = check_v4l2_settings(settings); !status.ok()) return status;
  V4l2Routes routes;
  find_v4l2_routes(node.io(), routes);
  Status status = settings.device[0] == '/' ? find_by_path(settings, routes, node, info)
                                            : find_by_sensor(settings, routes, node, info);
  if (status.ok()) status = read_v4l2_format(node, info);
  if (status.ok() && info.frame_bytes > static_cast<std::size_t>(settings.frame_bytes)) {
    status = {StatusCode::kBadDeviceSetting, "frame_bytes, less than a buffer of this device has",
              settings.frame_bytes, static_cast<std::int64_t>(info.frame_bytes)};
  }
  if (status.ok()) status = read_v4l2_sensor(settings, node, info);
  return status;
}

}  // namespace egofocus
