// CAN frame -> one line as `candump -L` writes it, LF included.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "hal/can_frame.hpp"

namespace egofocus {

inline constexpr std::size_t kMaxCandumpLineBytes = 192;

/// Six decimals, upper-case digits, FD frames with flags 0. Returns the characters written (no NUL), or 0 if
/// the line does not fit into `out` or the frame is not one: t_us below 0, an id beyond its bits, a length
/// beyond its kind, an interface name that is empty, has a space or more than 15 characters. Thread: any. RT:
/// yes.
std::size_t write_candump_line(const CanFrame& frame, std::string_view interface_name,
                               std::span<char> out) noexcept;

}  // namespace egofocus
