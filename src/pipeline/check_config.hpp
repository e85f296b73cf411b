// All checks of a configuration, in one place: afterwards a tick can run blind.
#pragma once

#include "egofocus/config.hpp"
#include "egofocus/status.hpp"

namespace egofocus {

/// The first thing that is wrong, or ok. Thread: any. RT: no (set-up).
Status check_config(const Config& config) noexcept;

}  // namespace egofocus
