// Python's door to the library's own front end. Arrays in, arrays out; everything that computes is elsewhere.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>

#include "pipeline/focus_energy.hpp"
#include "ray_cache.hpp"
#include "recording/error.hpp"
#include "recording/event_mask.hpp"
#include "recording/folder.hpp"
#include "recording_windows.hpp"
#include "window_stack.hpp"

namespace py = pybind11;
using namespace egofocus;
using training::Crop;
using training::RecordingWindows;
using training::WindowStack;

namespace {

training::RayCache& ray_cache() {
  static training::RayCache cache;
  return cache;
}

template <typename T>
using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;
using Grid = std::tuple<int, int, double, double, double, double>;    // width height fx fy cx cy
using Ladder = std::tuple<std::string, int, double, double, double>;  // kind hypotheses z_near span min
using Rectangle = std::tuple<int, int, int, int>;                     // x y width height

// Any time that is far from 0: samples count back from their window's end.
constexpr std::int64_t kEnd_us = 1'000'000;

[[noreturn]] void refuse(const std::string& what) {
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

std::vector<CameraMotion> motion_of(const Array<std::int32_t>& t_us, const Array<float>& velocity_m_s,
                                    const Array<float>& rate_rad_s) {
  const py::ssize_t n = t_us.size();
  const auto three_each = [n](const Array<float>& a) {
    return a.ndim() == 2 && a.shape(0) == n && a.shape(1) == 3;
  };
  if (n < 1 || !three_each(velocity_m_s) || !three_each(rate_rad_s))
    refuse("motion wants times [n] and velocities and rates [n, 3], n at least 1.");
  std::vector<CameraMotion> motion(static_cast<std::size_t>(n));
  for (py::ssize_t i = 0; i < n; ++i) {
    CameraMotion& m = motion[static_cast<std::size_t>(i)];
    m.t_us = kEnd_us + t_us.data()[i];
    if (i > 0 && m.t_us <= motion[static_cast<std::size_t>(i - 1)].t_us) refuse("motion times must rise.");
    for (int k = 0; k < 3; ++k) {
      m.velocity_m_s[k] = velocity_m_s.at(i, k);
      m.angular_rate_rad_s[k] = rate_rad_s.at(i, k);
    }
  }
  return motion;
}

template <typename T>
std::span<T> span_of(py::array_t<T>& array, py::ssize_t first, std::size_t count) {
  return {array.mutable_data() + first, count};
}

// counts: [D, height, width]; half: [D, ceil/2, ceil/2]; cells: [4, D, ceil/4, ceil/4]. Hypotheses that the
// ladder left out are all 0.
py::dict arrays_of(WindowStack& stack, const std::vector<std::string>& wanted) {
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

// What is true of the window, with or without a stack.
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

py::dict stack_window(const Array<std::int32_t>& t_us, const Array<std::uint16_t>& x,
                      const Array<std::uint16_t>& y, const Array<std::int32_t>& motion_t_us,
                      const Array<float>& velocity_m_s, const Array<float>& rate_rad_s, const Grid& camera,
                      int distortion, const std::vector<double>& coefficients, const Ladder& ladder,
                      int max_events, const Rectangle& crop, const std::vector<std::string>& wanted) {
  const py::ssize_t n = t_us.size();
  if (x.size() != n || y.size() != n) refuse("events want as many x and y as times.");
  if (coefficients.size() > 5 || distortion < 0 || distortion > 2) refuse("unknown distortion.");
  const std::vector<CameraMotion> motion = motion_of(motion_t_us, velocity_m_s, rate_rad_s);
  Config config;
  config.camera.intrinsics = intrinsics_of(camera);
  config.camera.distortion = static_cast<Distortion>(distortion);
  std::copy(coefficients.begin(), coefficients.end(), config.camera.coefficients);
  config.ladder = ladder_of(ladder);
  config.window.max_events = max_events;
  config.window.min_events = 0;
  const auto [left, top, width, height] = crop;
  std::unique_ptr<WindowStack> stack;
  bool has_stack = false;
  {
    const std::int32_t* times = t_us.data();
    const std::uint16_t* columns = x.data();
    const std::uint16_t* rows = y.data();
    const py::gil_scoped_release unlocked;
    const auto rays = ray_cache().rays(config);
    stack = std::make_unique<WindowStack>(config, Crop{left, top, width, height}, *rays);
    for (py::ssize_t i = 0; i < n; ++i) stack->add({kEnd_us + times[i], columns[i], rows[i], 0});
    has_stack = stack->run(kEnd_us - config.window.max_age_us, kEnd_us,
                           [&motion](std::int64_t begin_us, std::int64_t end_us, MotionTrack& out) {
                             integrate_track(motion, begin_us, end_us, out);
                             return true;
                           });
  }
  py::dict out = facts_of(*stack, has_stack, kEnd_us);
  if (std::find(wanted.begin(), wanted.end(), "event_mask") != wanted.end()) {
    recording::EventMask mask(config);
    std::vector<Event> events;
    for (py::ssize_t i = 0; i < n; ++i)
      events.push_back({kEnd_us + t_us.data()[i], x.data()[i], y.data()[i], 0});
    mask.add(events);
    const std::vector<std::uint8_t> pixels = mask.since(stack->ladder().begin_us);
    out["event_mask"] = py::array_t<std::uint8_t>(static_cast<py::ssize_t>(pixels.size()), pixels.data())
                            .reshape({py::ssize_t{config.camera.intrinsics.height_px},
                                      py::ssize_t{config.camera.intrinsics.width_px}});
  }
  return has_stack ? merged(std::move(out), arrays_of(*stack, wanted)) : out;
}

// float32, rounded to nearest: that costs no more than 2^-24 of a sum.
py::array_t<float> support(const Array<std::uint16_t>& cells, int side) {
  if (cells.ndim() != 3 || side < 1 || side > 7 || side % 2 == 0)
    refuse("support wants cells [n, height, width] and a side of 1, 3, 5 or 7.");
  const EnergyGrid grid{static_cast<std::int32_t>(cells.shape(2)), static_cast<std::int32_t>(cells.shape(1))};
  py::array_t<float> out({cells.shape(0), cells.shape(1), cells.shape(2)});
  const std::uint16_t* from = cells.data();
  float* to = out.mutable_data();
  const auto maps = static_cast<std::size_t>(cells.shape(0));
  const py::gil_scoped_release unlocked;
  std::vector<std::uint32_t> scratch(grid.size());
  std::vector<std::uint32_t> sums(grid.size());
  for (std::size_t i = 0; i < maps; ++i) {
    sum_support({from + i * grid.size(), grid.size()}, grid, side, scratch, sums);
    for (std::size_t n = 0; n < grid.size(); ++n) *to++ = static_cast<float>(sums[n]);
  }
  return out;
}

// A recording's windows, with the events and the motion that they rest on.
class Recording {
 public:
  Recording(const std::string& folder, const std::optional<std::string>& source,
            const std::optional<Ladder>& ladder)
      : windows_(opened(folder, source, ladder)) {}

  py::dict tick(std::int64_t tick_us, const std::vector<std::string>& wanted) {
    const bool has_stack = windows_.tick(tick_us);
    py::dict out = facts_of(windows_.stack(), has_stack, tick_us);
    return has_stack ? merged(std::move(out), arrays_of(windows_.stack(), wanted)) : out;
  }

  [[nodiscard]] std::vector<std::int64_t> truth_times_us() const {
    std::vector<std::int64_t> times;
    for (const auto& truth : windows_.folder().truth) times.push_back(truth.t_us);
    return times;
  }

  [[nodiscard]] py::array_t<float> truth_m(std::int64_t t_us) const {
    const recording::DepthTruth* truth = windows_.folder().truth_at(t_us);
    if (truth == nullptr) refuse("no truth at " + std::to_string(t_us) + " us.");
    const auto picture = recording::read_depth(*truth, windows_.folder().camera);
    return py::array_t<float>(static_cast<py::ssize_t>(picture.pixels.size()), picture.pixels.data())
        .reshape({py::ssize_t{picture.height_px}, py::ssize_t{picture.width_px}});
  }

  // t_us before the tick, x, y
  [[nodiscard]] py::tuple events(std::int64_t tick_us) const {
    const std::vector<Event> events = windows_.events();
    const auto n = static_cast<py::ssize_t>(events.size());
    py::array_t<std::int32_t> t(n);
    py::array_t<std::uint16_t> x(n);
    py::array_t<std::uint16_t> y(n);
    for (py::ssize_t i = 0; i < n; ++i) {
      const Event& event = events[static_cast<std::size_t>(i)];
      t.mutable_at(i) = static_cast<std::int32_t>(event.t_us - tick_us);
      x.mutable_at(i) = event.x;
      y.mutable_at(i) = event.y;
    }
    return py::make_tuple(t, x, y);
  }

 private:
  static recording::Folder opened(const std::string& path, const std::optional<std::string>& source,
                                  const std::optional<Ladder>& ladder) {
    std::optional<MotionSource> motion;
    if (source) {
      if (*source != "odometry" && *source != "poses")
        refuse("motion source `" + *source + "`: odometry or poses.");
      motion = *source == "poses" ? MotionSource::kPoses : MotionSource::kOdometry;
    }
    recording::Folder folder = recording::open_folder(path, motion);
    if (ladder) folder.camera.config.ladder = ladder_of(*ladder);
    return folder;
  }

  RecordingWindows windows_;
};

}  // namespace

PYBIND11_MODULE(egofocus_stack, module) {
  module.doc() =
      "The library's own front end: events and motion -> ladder, stack of warped events, energies.";
  py::register_exception<recording::Error>(module, "StackError");
  module.def(
      "stack_window", &stack_window, py::kw_only(), py::arg("t_us"), py::arg("x"), py::arg("y"),
      py::arg("motion_t_us"), py::arg("velocity_m_s"), py::arg("rate_rad_s"), py::arg("camera"),
      py::arg("distortion"), py::arg("coefficients"), py::arg("ladder"), py::arg("max_events"),
      py::arg("crop") = Rectangle{0, 0, 0, 0}, py::arg("wanted"),
      "One window: times count back from its end. wanted: counts, half, cells, argmax, sgm, event_mask.");
  module.def(
      "keep_rays", [](std::size_t bytes) { ray_cache().keep(bytes); }, py::arg("bytes"),
      "How much the tables of cameras seen last may take.");
  module.def("support", &support, py::arg("cells"), py::arg("side"), "Two boxes of side x side cells.");
  py::class_<Recording>(module, "Recording")
      .def(py::init<const std::string&, const std::optional<std::string>&, const std::optional<Ladder>&>(),
           py::arg("folder"), py::arg("source") = std::nullopt, py::arg("ladder") = std::nullopt)
      .def("tick", &Recording::tick, py::arg("t_us"), py::arg("wanted"))
      .def("truth_times_us", &Recording::truth_times_us)
      .def("truth_m", &Recording::truth_m, py::arg("t_us"))
      .def("events", &Recording::events, py::arg("tick_us"));
}
