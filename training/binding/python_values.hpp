// Values that cross Python's door: tuples and arrays in, dicts of arrays out. A wrong one throws
// recording::Error (kUsage).
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "egofocus/config.hpp"
#include "pipeline/motion_track.hpp"
#include "window_stack.hpp"

namespace egofocus::training {

namespace py = pybind11;

template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;
using Grid = std::tuple<int, int, double, double, double, double>;    // width height fx fy cx cy
using Ladder = std::tuple<std::string, int, double, double, double>;  // kind hypotheses z_near span min
/// [(map, side of its support)], floor_events and floor_noise in thousandths
using FocusMaps = std::tuple<std::vector<std::tuple<std::string, int>>, int, int>;
using Rectangle = std::tuple<int, int, int, int>;  // x y width height

/// The end of a window whose times count back from it: any time that is far from 0.
inline constexpr std::int64_t kEnd_us = 1'000'000;

[[noreturn]] void refuse(const std::string& what);

Intrinsics intrinsics_of(const Grid& grid);
LadderConfig ladder_of(const Ladder& ladder);
FocusInputConfig focus_config_of(const FocusMaps& maps);
/// (focus u8 [D, maps, ceil/4, ceil/4], context u8 [channels, ceil/4, ceil/4])
py::tuple arrays_of_input(const NetworkInput& input, std::int32_t hypotheses);
/// t_us [n], rising, and velocities and rates [n, 3]; times become those of a window that ends at kEnd_us.
std::vector<MotionSample> motion_of(const Array<std::int32_t>& t_us, const Array<float>& velocity_m_s,
                                    const Array<float>& rate_rad_s);

/// The wanted ones of: counts u8 [D, height, width]; half u8 [D, ceil/2, ceil/2]; cells u16 [4, D, ceil/4,
/// ceil/4]; focus and context of the given maps; argmax and sgm u16 [height, width] in 1/256 hypothesis, with
/// argmax_confidence and sgm_confidence. Hypotheses that the ladder left out are all 0.
py::dict arrays_of(WindowStack& stack, const std::vector<std::string>& wanted,
                   const std::optional<FocusMaps>& maps);

/// What is true of the window, with or without a stack.
py::dict facts_of(const WindowStack& stack, bool has_stack, std::int64_t end_us);

py::dict merged(py::dict into, const py::dict& more);

}  // namespace egofocus::training
