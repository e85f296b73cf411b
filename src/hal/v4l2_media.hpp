// Which event sensors this machine has, and which video node the events of each come out of.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/v4l2_io.hpp"

namespace egofocus {

/// One event sensor of a media device. Paths are empty where there is none.
struct V4l2Route {
  char sensor[32] = {};       ///< name of its entity, "imx636 10-003c"
  char media_path[32] = {};   ///< "/dev/media0"
  char sensor_path[64] = {};  ///< of its sub-device, with the controls
  char video_path[64] = {};   ///< where enabled links lead to; "": the links are not set up
  std::uint32_t video_major = 0;
  std::uint32_t video_minor = 0;
};

struct V4l2Routes {
  static constexpr std::size_t kMost = 8;
  V4l2Route items[kMost];
  std::size_t count = 0;
  std::size_t forbidden = 0;  ///< media devices that this user may not open
  [[nodiscard]] std::span<const V4l2Route> all() const noexcept { return {items, count}; }
};

/// Event sensors (entities of function CAM_SENSOR named imx636... or genx320...) of /dev/media0 .. media15,
/// and the first video node that enabled links lead to from each. Sources: Linux
/// Documentation/userspace-api/media/mediactl; prophesee-ai/openeb hal_psee_plugins, boards/v4l2. Thread:
/// any. RT: no.
void find_v4l2_routes(const V4l2Io& io, V4l2Routes& routes) noexcept;

/// The model of a sensor's entity: "imx636", "genx320", or "" for another one. Thread: any. RT: yes.
const char* sensor_model(const char* entity) noexcept;

}  // namespace egofocus
