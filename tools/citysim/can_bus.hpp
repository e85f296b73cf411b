// A classic CAN bus as a recorder sees it: one frame at a time, the lowest id first, stamped at its end.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "hal/can_frame.hpp"

namespace egofocus::citysim {

/// How long a frame is on the wire, stuff bits at their usual number, with the pause behind it.
[[nodiscard]] std::int64_t frame_time_us(const CanFrame& frame, int bits_per_s);

/// In: frames with the time from which their sender wants the bus. Out: the same in the order of the wire,
/// t_us at the end of each. `busy_us` is the time that the bus was in use.
[[nodiscard]] std::vector<CanFrame> arbitrated(std::vector<CanFrame> ready, int bits_per_s,
                                               std::int64_t& busy_us);

/// As `candump -L` writes it. Throws std::invalid_argument for a frame that is none.
[[nodiscard]] std::string candump_text(std::span<const CanFrame> frames, const char* interface_name = "can0");

}  // namespace egofocus::citysim
