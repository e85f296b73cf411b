// What systemd wants to be told (sd_notify(3)), over the socket that it names; elsewhere nothing happens.
#pragma once

#include <cstdint>
#include <string_view>

namespace egofocus::daemon {

/// Lines such as "READY=1\nSTATUS=...". Never waits. Thread: the service's.
void notify(std::string_view lines) noexcept;

/// Half of systemd's WatchdogSec, in microseconds; 0: no watchdog is asked for.
[[nodiscard]] std::int64_t watchdog_period_us() noexcept;

}  // namespace egofocus::daemon
