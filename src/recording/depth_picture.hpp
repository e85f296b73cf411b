// What people look at: inverse depth in colour, events, confidence. All from plain spans of one frame.
#pragma once

#include <cstdint>
#include <span>

#include "egofocus/types.hpp"
#include "recording/picture.hpp"

namespace egofocus::recording {

/// Colour of `value` in [0, 255]: 0 is far (dark blue), 255 is near (bright yellow). Brightness rises all the
/// way, so that the order survives a grey print and colour blindness.
[[nodiscard]] Rgb depth_colour(std::uint8_t value) noexcept;

/// The inverse depth that only 1 % of the known pixels exceed: a good `nearest` for a whole recording. 1 if
/// none is known.
[[nodiscard]] std::uint16_t nearest_inverse_depth(std::span<const std::uint16_t> inverse_depth,
                                                  std::span<const std::uint8_t> confidence);

/// Colour is linear in inverse depth, from 0 (infinity) to `nearest` and beyond. Unknown pixels (confidence
/// 0) are dark grey. Both spans hold width * height values; `nearest` > 0.
[[nodiscard]] RgbPicture depth_picture(std::int32_t width_px, std::int32_t height_px,
                                       std::span<const std::uint16_t> inverse_depth,
                                       std::span<const std::uint8_t> confidence, std::uint16_t nearest);

/// White ground, ON events red, OFF events blue; where both came, the later one. Events outside are skipped.
[[nodiscard]] RgbPicture event_picture(std::int32_t width_px, std::int32_t height_px,
                                       std::span<const Event> events);

/// Confidence as brightness.
[[nodiscard]] GreyPicture confidence_picture(std::int32_t width_px, std::int32_t height_px,
                                             std::span<const std::uint8_t> confidence);

}  // namespace egofocus::recording
