// Where sources plug in: what [source] names, opened and ready to be attached. A new kind of source has a
// name in daemon_config.cpp and a branch in open_source.cpp; nothing else knows of it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "device_facts.hpp"
#include "egofocus/source.hpp"
#include "recorder.hpp"
#include "setup.hpp"

namespace egofocus::daemon {

struct OpenSources {
  std::vector<Source> to_attach;            ///< Engine::attach() each, in this order
  std::vector<std::shared_ptr<void>> kept;  ///< what they rest on; outlives the engine
  std::vector<std::function<void(std::vector<DeviceFact>&)>> devices;  ///< each appends. Thread: any.
  std::int64_t first_tick_us = 0;                                      ///< t_0, on the clock of [source]
  std::function<bool(std::int64_t)>
      ends_before;  ///< will nothing come for a tick at this time? Thread: the tick's.
};

/// Opens devices and files; what passes goes to `recorder` as well, which outlives the sources. Throws Error.
[[nodiscard]] OpenSources open_sources(const Setup& setup, Recorder& recorder);

}  // namespace egofocus::daemon
