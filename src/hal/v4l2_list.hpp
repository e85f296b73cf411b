// What `egofocus devices` says about V4L2: each event sensor, and what keeps it from being used.
#pragma once

#include <cstddef>
#include <span>

#include "egofocus/status.hpp"
#include "hal/v4l2_camera.hpp"

namespace egofocus {

enum class V4l2State : std::uint8_t {
  kFine,
  kNoPermission,  ///< a media device, sub-device or video node that this user may not open
  kBusy,          ///< another process streams
  kNotLinked,     ///< a sensor without an enabled way to a video node: media links are not set up
  kNoFormat,      ///< the node's format cannot carry events, or nothing tells the encoding or the geometry
  kUnusable,      ///< anything else; `status` says what
};

struct V4l2Listed {
  V4l2State state = V4l2State::kUnusable;
  Status status;        ///< why it is not fine
  V4l2CameraInfo info;  ///< what could be read
};

/// Event sensors of media devices, then video nodes with an event fourcc and no such sensor (/dev/video0 ..
/// video63), then one entry without a sensor if media devices may not be opened. Writes as many as fit,
/// returns how many there are. Sets nothing but asks the queue of each node for no buffers, which frees none.
/// Thread: any. RT: no.
std::size_t list_v4l2_cameras(std::span<V4l2Listed> out, const V4l2Io& io = system_v4l2_io()) noexcept;

}  // namespace egofocus
