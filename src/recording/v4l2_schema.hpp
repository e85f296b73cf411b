// The keys of [v4l2], each once: see camera_schema.hpp.
#pragma once

#include <string>

#include "hal/v4l2_camera.hpp"
#include "recording/error.hpp"
#include "recording/toml_names.hpp"

namespace egofocus::recording {

/// The section of a live sensor behind V4L2. Not given: the file has none.
struct V4l2Setup {
  bool is_given = false;
  V4l2CameraSettings camera;
};

/// -1: as the sensor says.
inline constexpr Names<int, 5> kV4l2FormatNames{{{"sensor", -1},
                                                 {"evt2", static_cast<int>(EvtFormat::kEvt2)},
                                                 {"evt21", static_cast<int>(EvtFormat::kEvt21)},
                                                 {"evt21me", static_cast<int>(EvtFormat::kEvt21Legacy)},
                                                 {"evt3", static_cast<int>(EvtFormat::kEvt3)}}};
inline constexpr Names<V4l2FrameEnd, 3> kFrameEndNames{{{"auto", V4l2FrameEnd::kAuto},
                                                        {"bytes_used", V4l2FrameEnd::kBytesUsed},
                                                        {"marker", V4l2FrameEnd::kMarker}}};

template <typename Section>
void describe(Section& s, V4l2ControlSetting& v) {
  s.name("name", v.name);
  s.optional("value", v.value);
}

template <typename Section>
void describe(Section& s, V4l2Setup& v) {
  v.is_given = true;
  V4l2CameraSettings& camera = v.camera;
  std::string device = camera.device;
  s.optional("device", device);
  if (device.size() >= sizeof camera.device)
    throw Error(ExitCode::kConfiguration, "[v4l2] `device`",
                "must have at most " + std::to_string(sizeof camera.device - 1) + " characters.");
  camera.device[device.copy(camera.device, device.size())] = '\0';
  int format = camera.has_format ? static_cast<int>(camera.format) : -1;
  s.choice("format", format, kV4l2FormatNames);
  camera.has_format = format >= 0;
  if (camera.has_format) camera.format = static_cast<EvtFormat>(format);
  s.choice("frame_end", camera.frame_end, kFrameEndNames);
  s.optional("decode_unmarked", camera.decode_unmarked);
  s.optional("buffers", camera.buffers);
  s.optional("frame_bytes", camera.frame_bytes);
  s.optional("silence_ms", camera.silence_ms);
  s.optional("reopen", camera.reopen);
  s.tables("controls", camera.controls, camera.control_count);
}

}  // namespace egofocus::recording
