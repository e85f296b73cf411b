#include "python_values.hpp"

#include <algorithm>
#include <iterator>
#include <span>
#include <string_view>

#include "pipeline/focus_energy.hpp"
#include "recording/error.hpp"

namespace egofocus::training {
namespace {

template <typename T>
std::span<T> span_of(py::array_t<T>& array, py::ssize_t first, std::size_t count) {
  return {array.mutable_data() + first, count};
}

}  // namespace

void refuse(const std::string& what) {
  throw recording::Error(recording::ExitCode::kUsage, "egofocus_stack", what);
}

Intrinsics intrinsics_of(const Grid& grid) {
  const auto [width, height, fx, fy, cx, cy] = grid;
  return {width, height, fx, fy, cx, cy};
}

LadderConfig ladder_of(const Ladder& ladder) {
  const auto& [kind, hypotheses, z_near_m, span_px, min_parallax_px] = ladder;
  if (kind != "parallax" && kind != "metric") refuse("ladder kind `" + kind + "`: parallax or metric.");
  return {kind == "metric" ? LadderKind::kMetric : LadderKind::kParallax, hypotheses, z_near_m, span_px,
          min_parallax_px};
}

FocusInputConfig focus_config_of(const FocusMaps& maps) {
  const auto& [entries, floor_events_milli, floor_noise_milli] = maps;
  FocusInputConfig config;
  if (entries.empty() || entries.size() > std::size(config.maps))
    refuse("the network's input has 1 to " + std::to_string(std::size(config.maps)) + " maps.");
  config.map_count = 0;
  for (const auto& [name, side] : entries) {
    FocusMap& map = config.maps[config.map_count++];
    const std::string_view names[] = {"gradient", "gradient_x", "gradient_y", "squares"};
    const auto* const found = std::find(std::begin(names), std::end(names), name);
    if (found == std::end(names)) refuse("map `" + name + "`: gradient, gradient_x, gradient_y or squares.");
    map = {static_cast<FocusMapKind>(found - std::begin(names)), side};
  }
  config.floor_events_milli = floor_events_milli;
  config.floor_noise_milli = floor_noise_milli;
  return config;
}

py::tuple arrays_of_input(const NetworkInput& input, std::int32_t hypotheses) {
  const py::ssize_t plane = static_cast<py::ssize_t>(input.cells.size());
  const auto array = [&](const std::vector<std::uint8_t>& values) {
    return py::array_t<std::uint8_t>(static_cast<py::ssize_t>(values.size()), values.data());
  };
  const py::ssize_t h = input.cells.height;
  const py::ssize_t w = input.cells.width;
  const auto maps = static_cast<py::ssize_t>(input.focus.size()) / plane / hypotheses;
  const auto channels = static_cast<py::ssize_t>(input.context.size()) / plane;
  return py::make_tuple(array(input.focus).reshape({py::ssize_t{hypotheses}, maps, h, w}),
                        array(input.context).reshape({channels, h, w}));
}

std::vector<MotionSample> motion_of(const Array<std::int32_t>& t_us, const Array<float>& velocity_m_s,
                                    const Array<float>& rate_rad_s) {
  const py::ssize_t n = t_us.size();
  const auto three_each = [n](const Array<float>& a) {
    return a.ndim() == 2 && a.shape(0) == n && a.shape(1) == 3;
  };
  if (n < 1 || !three_each(velocity_m_s) || !three_each(rate_rad_s))
    refuse("motion wants times [n] and velocities and rates [n, 3], n at least 1.");
  std::vector<MotionSample> motion(static_cast<std::size_t>(n));
  for (py::ssize_t i = 0; i < n; ++i) {
    MotionSample& m = motion[static_cast<std::size_t>(i)];
    m.t_us = kEnd_us + t_us.data()[i];
    if (i > 0 && m.t_us <= motion[static_cast<std::size_t>(i - 1)].t_us) refuse("motion times must rise.");
    for (int k = 0; k < 3; ++k) {
      m.velocity_m_s[k] = velocity_m_s.at(i, k);
      m.angular_rate_rad_s[k] = rate_rad_s.at(i, k);
    }
  }
  return motion;
}

py::dict arrays_of(WindowStack& stack, const std::vector<std::string>& wanted,
                   const std::optional<FocusMaps>& maps) {
  const auto wants = [&wanted](const char* name) {
    return std::find(wanted.begin(), wanted.end(), name) != wanted.end();
  };
  const Intrinsics& grid = stack.grid();
  const py::ssize_t depth = stack.config().ladder.hypotheses;
  const py::ssize_t width = grid.width_px;
  const py::ssize_t height = grid.height_px;
  const auto pixels = static_cast<std::size_t>(width * height);
  const std::int32_t used = stack.ladder().count;
  py::dict out;
  if (wants("counts")) {
    py::array_t<std::uint8_t> counts({depth, height, width});
    std::fill_n(counts.mutable_data(), counts.size(), std::uint8_t{0});
    for (std::int32_t k = 0; k < used; ++k)
      std::copy_n(stack.warp().plane(k).data(), pixels, counts.mutable_data(k, 0, 0));
    out["counts"] = counts;
  }
  if (wants("half")) {
    const py::ssize_t h = (height + 1) / 2;
    const py::ssize_t w = (width + 1) / 2;
    py::array_t<std::uint8_t> half({depth, h, w});
    std::fill_n(half.mutable_data(), half.size(), std::uint8_t{0});
    for (std::int32_t k = 0; k < used; ++k)
      halve_counts(stack.warp().plane(k), grid.width_px, grid.height_px,
                   span_of(half, k * h * w, static_cast<std::size_t>(h * w)));
    out["half"] = half;
  }
  if (wants("cells")) {
    const EnergyGrid energy = energy_grid(grid.width_px, grid.height_px);
    py::array_t<std::uint16_t> cells(
        {py::ssize_t{4}, depth, py::ssize_t{energy.height}, py::ssize_t{energy.width}});
    std::fill_n(cells.mutable_data(), cells.size(), std::uint16_t{0});
    std::vector<std::uint32_t> scratch(4 * static_cast<std::size_t>(width));
    const auto part = [&](py::ssize_t map, std::int32_t k) {
      return std::span<std::uint16_t>{cells.mutable_data(map, k, 0, 0), energy.size()};
    };
    {
      const auto gradient_x = part(0, 0);
      const auto gradient_y = part(1, 0);
      const auto squares = part(2, 0);
      const auto counts = part(3, 0);
      const py::gil_scoped_release unlocked;
      for (std::int32_t k = 0; k < used; ++k) {
        const std::size_t at = static_cast<std::size_t>(k) * energy.size();
        sum_cells(stack.warp().plane(k), grid.width_px, grid.height_px, scratch,
                  {{gradient_x.data() + at, energy.size()},
                   {gradient_y.data() + at, energy.size()},
                   {squares.data() + at, energy.size()},
                   {counts.data() + at, energy.size()}});
      }
    }
    out["cells"] = cells;
  }
  if (wants("focus") || wants("context")) {
    if (!maps) refuse("focus and context need the network's maps.");
    const FocusInputConfig config = focus_config_of(*maps);
    NetworkInput input;
    {
      const py::gil_scoped_release unlocked;
      input = stack.input(config);
    }
    const py::tuple both = arrays_of_input(input, stack.config().ladder.hypotheses);
    out["focus"] = both[0];
    out["context"] = both[1];
  }
  for (const bool smoothing : {false, true}) {
    if (!wants(smoothing ? "sgm" : "argmax")) continue;
    const training::ClassicalDepth depth_map = stack.classical(smoothing);
    const auto size = static_cast<py::ssize_t>(pixels);
    const std::string name = smoothing ? "sgm" : "argmax";
    out[name.c_str()] = py::array_t<std::uint16_t>(size, depth_map.index_q8.data()).reshape({height, width});
    out[(name + "_confidence").c_str()] =
        py::array_t<std::uint8_t>(size, depth_map.confidence.data()).reshape({height, width});
  }
  return out;
}

py::dict facts_of(const WindowStack& stack, bool has_stack, std::int64_t end_us) {
  const HypothesisLadder& ladder = stack.ladder();
  const Intrinsics& grid = stack.grid();
  const double* c = stack.baseline_m();
  py::dict out;
  out["has_stack"] = has_stack;
  out["hypotheses"] = ladder.count;
  out["step_per_m"] = ladder.step_per_m;
  out["parallax_px"] = ladder.parallax_px;
  out["begin_us"] = ladder.begin_us - end_us;
  out["events"] = stack.events();
  out["votes"] = has_stack ? stack.warp().votes() : 0;
  out["baseline_m"] = std::make_tuple(c[0], c[1], c[2]);
  out["grid"] = Grid{grid.width_px, grid.height_px, grid.fx_px, grid.fy_px, grid.cx_px, grid.cy_px};
  return out;
}

py::dict merged(py::dict into, const py::dict& more) {
  for (const auto& item : more) into[item.first] = item.second;
  return into;
}

}  // namespace egofocus::training
