// Cameras and buses as sources: what [source] names beside "replay".
#pragma once

#include "open_source.hpp"

namespace egofocus::daemon {

/// Opens the camera, and the bus for a moment: what cannot work is told before anything starts. first_tick_us
/// and ends_before are left to the caller. Throws Error: kNoDevice, kDevice, kConfiguration (a sensor of
/// another size than camera.toml's), kFile and kBadFile (the DBC).
[[nodiscard]] OpenSources open_live_sources(const Setup& setup, Recorder& recorder);

}  // namespace egofocus::daemon
