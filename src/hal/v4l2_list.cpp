#include "hal/v4l2_list.hpp"

#include <linux/videodev2.h>

#include <cerrno>

#include "hal/v4l2_text.hpp"

namespace egofocus {
namespace {

constexpr int kMostNodes = 64;

V4l2State state_of(const Status& status) noexcept {
  switch (status.code()) {
    case StatusCode::kOk:
      return V4l2State::kFine;
    case StatusCode::kNoPermission:
      return V4l2State::kNoPermission;
    case StatusCode::kDeviceBusy:
      return V4l2State::kBusy;
    case StatusCode::kUnsupportedDevice:
    case StatusCode::kBadDeviceSetting:
      return V4l2State::kNoFormat;
    default:
      return V4l2State::kUnusable;
  }
}

// Only the process that holds a queue may ask it for no buffers.
bool is_busy(const V4l2File& node, const V4l2CameraInfo& info) noexcept {
  v4l2_requestbuffers none{};
  none.type = info.is_multiplanar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  none.memory = V4L2_MEMORY_MMAP;
  return node.ioctl(VIDIOC_REQBUFS, none) == -EBUSY;
}

// Reads without setting: a sensor that is told nothing keeps its marker switched as it is.
void look_at(const V4l2Route& route, const V4l2Io& io, V4l2Listed& listed) noexcept {
  listed = {};
  listed.info.route = route;
  if (route.video_path[0] == '\0') {
    listed.state = V4l2State::kNotLinked;
    listed.status = {StatusCode::kNoDevice,
                     "a video node behind the sensor: set up the media links, docs/v4l2.md"};
    return;
  }
  V4l2File node(io);
  const int code = node.open(route.video_path);
  if (code == -EACCES || code == -EPERM) {
    listed.status = {StatusCode::kNoPermission, "the video node", -code};
  } else if (code < 0) {
    listed.status = {StatusCode::kIo, "the video node", -code};
  } else {
    V4l2CameraSettings nothing;
    nothing.frame_end = V4l2FrameEnd::kBytesUsed;
    listed.status = read_v4l2_format(node, listed.info);
    if (listed.status.ok()) listed.status = read_v4l2_sensor(nothing, node, listed.info);
    if (listed.status.ok() && is_busy(node, listed.info))
      listed.status = {StatusCode::kDeviceBusy, "the video node", EBUSY};
  }
  listed.state = state_of(listed.status);
}

bool is_event_node(const char* path, const V4l2Io& io, const V4l2Routes& routes) noexcept {
  V4l2File node(io);
  if (node.open(path) < 0) return false;
  std::uint32_t major = 0;
  std::uint32_t minor = 0;
  if (node.number(major, minor) == 0) {
    for (const V4l2Route& route : routes.all()) {
      if (route.video_path[0] != '\0' && route.video_major == major && route.video_minor == minor)
        return false;
    }
  }
  V4l2CameraInfo info;
  EvtFormat format{};
  return read_v4l2_format(node, info).ok() && evt_format_of(info.fourcc, format);
}

}  // namespace

std::size_t list_v4l2_cameras(std::span<V4l2Listed> out, const V4l2Io& io) noexcept {
  std::size_t found = 0;
  V4l2Routes routes;
  find_v4l2_routes(io, routes);
  for (const V4l2Route& route : routes.all()) {
    if (found < out.size()) look_at(route, io, out[found]);
    ++found;
  }
  for (int i = 0; i < kMostNodes; ++i) {
    V4l2Route route;
    V4l2Text(route.video_path).text("/dev/video").number(i);
    if (!is_event_node(route.video_path, io, routes)) continue;
    if (found < out.size()) look_at(route, io, out[found]);
    ++found;
  }
  if (routes.forbidden > 0) {
    if (found < out.size()) {
      out[found] = {};
      out[found].state = V4l2State::kNoPermission;
      out[found].status = {StatusCode::kNoPermission, "media devices (/dev/media*)", EACCES};
    }
    ++found;
  }
  return found;
}

}  // namespace egofocus
