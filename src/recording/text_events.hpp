// Text events, one a line: `t x y p` (seconds, pixels, 1 or 0; -1 counts as 0).
#pragma once

#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "egofocus/types.hpp"

namespace egofocus::recording {

/// Every line is in `events`, `blank` or one of the dropped kinds.
struct TextEvents {
  std::vector<Event> events;  ///< sorted by time
  std::uint64_t lines = 0;
  std::uint64_t blank = 0;         ///< empty, or a comment
  std::uint64_t malformed = 0;     ///< not four numbers in range: dropped
  std::uint64_t out_of_order = 0;  ///< earlier than the event before: dropped
};

/// `progress(done, all)` is called now and then with bytes.
[[nodiscard]] TextEvents parse_text_events(
    std::string_view text, const std::function<void(std::size_t, std::size_t)>& progress = {});

}  // namespace egofocus::recording
