// The confidence's curve as a picture that every browser shows.
#pragma once

#include <string>

#include "recording/evaluation.hpp"

namespace egofocus::app {

/// SVG: abs_rel over the share of pixels removed, per method with a confidence; dashed: its oracle.
[[nodiscard]] std::string curve_svg(const recording::SequenceScore& score);

}  // namespace egofocus::app
