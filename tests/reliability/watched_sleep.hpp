// Every absolute sleep of this program, the engine's included, with how late its thread woke.
#pragma once

#include <cstdint>

namespace egofocus::reliability {

/// Of the calling thread's newest sleep that ran to its end: nanoseconds from its deadline to the moment that
/// the thread ran again. RT: yes.
[[nodiscard]] std::int64_t woke_late_ns() noexcept;

}  // namespace egofocus::reliability
