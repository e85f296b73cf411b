// Python's door to the library's own front end. Arrays in, arrays out; everything that computes is elsewhere.
#include <algorithm>
#include <memory>
#include <optional>
#include <string>

#include "network_input.hpp"
#include "python_values.hpp"
#include "ray_cache.hpp"
#include "recording/error.hpp"
#include "recording/event_mask.hpp"
#include "recording/folder.hpp"
#include "recording/replay.hpp"
#include "recording_windows.hpp"
#include "window_stack.hpp"

namespace py = pybind11;
using namespace egofocus;
using namespace egofocus::training;

namespace {

RayCache& ray_cache() {
  static RayCache cache;
  return cache;
}

Config camera_config(const Grid& camera, int distortion, const std::vector<double>& coefficients) {
  if (coefficients.size() > 5 || distortion < 0 || distortion > 2) refuse("unknown distortion.");
  Config config;
  config.camera.intrinsics = intrinsics_of(camera);
  config.camera.distortion = static_cast<Distortion>(distortion);
  std::copy(coefficients.begin(), coefficients.end(), config.camera.coefficients);
  return config;
}

py::dict stack_window(const Array<std::int32_t>& t_us, const Array<std::uint16_t>& x,
                      const Array<std::uint16_t>& y, const Array<std::int32_t>& motion_t_us,
                      const Array<float>& velocity_m_s, const Array<float>& rate_rad_s, const Grid& camera,
                      int distortion, const std::vector<double>& coefficients, const Ladder& ladder,
                      int max_events, const Rectangle& crop, const std::vector<std::string>& wanted,
                      const std::optional<FocusMaps>& maps) {
  const py::ssize_t n = t_us.size();
  if (x.size() != n || y.size() != n) refuse("events want as many x and y as times.");
  const std::vector<MotionSample> motion = motion_of(motion_t_us, velocity_m_s, rate_rad_s);
  Config config = camera_config(camera, distortion, coefficients);
  config.ladder = ladder_of(ladder);
  config.window.max_events = max_events;
  config.window.min_events = 0;
  // No further back than the motion is known, as in the tick.
  config.window.max_age_us =
      std::clamp<std::int64_t>(kEnd_us - motion.front().t_us, 1000, config.window.max_age_us);
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
  return has_stack ? merged(std::move(out), arrays_of(*stack, wanted, maps)) : out;
}

// int32 [height, width] of the sensor.
py::array_t<std::int32_t> pixel_table(const Intrinsics& sensor, const std::vector<std::int32_t>& pixels) {
  return py::array_t<std::int32_t>(static_cast<py::ssize_t>(pixels.size()), pixels.data())
      .reshape({py::ssize_t{sensor.height_px}, py::ssize_t{sensor.width_px}});
}

py::array_t<std::int32_t> grid_pixels(const Grid& camera, int distortion,
                                      const std::vector<double>& coefficients, const Rectangle& crop) {
  const Config config = camera_config(camera, distortion, coefficients);
  Intrinsics grid = config.camera.intrinsics;
  const auto [left, top, width, height] = crop;
  if (width > 0) {
    grid.width_px = width;
    grid.height_px = height;
    grid.cx_px -= left;
    grid.cy_px -= top;
  }
  return pixel_table(config.camera.intrinsics, recording::grid_pixels(*ray_cache().rays(config), grid));
}

// The stage alone, on any planes.
py::tuple focus_input(const Array<std::uint8_t>& planes, int hypotheses, const Grid& grid,
                      const std::tuple<double, double, double>& baseline_m, double step_per_m,
                      const FocusMaps& maps, int threads) {
  const Intrinsics size = intrinsics_of(grid);
  if (planes.ndim() != 3 || planes.shape(0) < 1 || planes.shape(0) > hypotheses ||
      hypotheses > FocusInput::kMostHypotheses || planes.shape(1) != size.height_px ||
      planes.shape(2) != size.width_px || size.width_px < 1 || size.height_px < 1)
    refuse(
        "focus_input wants planes [1 to hypotheses, height, width] of the grid, and at most 64 hypotheses.");
  HypothesisLadder ladder;
  ladder.count = static_cast<std::int32_t>(planes.shape(0));
  ladder.step_per_m = step_per_m;
  const double centre_m[3] = {std::get<0>(baseline_m), std::get<1>(baseline_m), std::get<2>(baseline_m)};
  WorkerPool pool;
  recording::require(pool.start(threads, 0, -1), "focus_input");
  return arrays_of_input(
      network_input(focus_config_of(maps), size, hypotheses,
                    {planes.data(), static_cast<std::size_t>(planes.size())}, ladder, centre_m, pool),
      hypotheses);
}

// A recording's windows, with the events and the motion that they rest on.
class Recording {
 public:
  Recording(const std::string& folder, const std::optional<std::string>& source,
            const std::optional<Ladder>& ladder)
      : windows_(opened(folder, source, ladder)) {}

  py::dict tick(std::int64_t tick_us, const std::vector<std::string>& wanted,
                const std::optional<FocusMaps>& maps) {
    const bool has_stack = windows_.tick(tick_us);
    py::dict out = facts_of(windows_.stack(), has_stack, tick_us);
    return has_stack ? merged(std::move(out), arrays_of(windows_.stack(), wanted, maps)) : out;
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

  // t_us before the tick, x, y, polarity
  [[nodiscard]] py::tuple events(std::int64_t tick_us) const {
    const std::vector<Event> events = windows_.events();
    const auto n = static_cast<py::ssize_t>(events.size());
    py::array_t<std::int32_t> t(n);
    py::array_t<std::uint16_t> x(n);
    py::array_t<std::uint16_t> y(n);
    py::array_t<std::uint8_t> polarity(n);
    for (py::ssize_t i = 0; i < n; ++i) {
      const Event& event = events[static_cast<std::size_t>(i)];
      t.mutable_at(i) = static_cast<std::int32_t>(event.t_us - tick_us);
      x.mutable_at(i) = event.x;
      y.mutable_at(i) = event.y;
      polarity.mutable_at(i) = event.polarity;
    }
    return py::make_tuple(t, x, y, polarity);
  }

  // t_us before the tick, velocity m/s [n, 3] and rate rad/s [n, 3] of the camera
  [[nodiscard]] py::tuple motion(std::int64_t tick_us) const {
    const std::vector<MotionSample> motion = windows_.motion();
    const auto n = static_cast<py::ssize_t>(motion.size());
    py::array_t<std::int32_t> t(n);
    py::array_t<float> velocity({n, py::ssize_t{3}});
    py::array_t<float> rate({n, py::ssize_t{3}});
    for (py::ssize_t i = 0; i < n; ++i) {
      const MotionSample& m = motion[static_cast<std::size_t>(i)];
      t.mutable_at(i) = static_cast<std::int32_t>(m.t_us - tick_us);
      for (py::ssize_t axis = 0; axis < 3; ++axis) {
        velocity.mutable_at(i, axis) = static_cast<float>(m.velocity_m_s[axis]);
        rate.mutable_at(i, axis) = static_cast<float>(m.angular_rate_rad_s[axis]);
      }
    }
    return py::make_tuple(t, velocity, rate);
  }

  [[nodiscard]] py::array_t<std::int32_t> grid_pixels() {
    const Config& config = windows_.folder().camera.config;
    if (pixels_.empty()) pixels_ = recording::grid_pixels(config);
    return pixel_table(config.camera.intrinsics, pixels_);
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
  std::vector<std::int32_t> pixels_;  // once wanted
};

}  // namespace

PYBIND11_MODULE(egofocus_stack, module) {
  module.doc() =
      "The library's own front end: events and motion -> ladder, stack of warped events, the network's "
      "input.";
  py::register_exception<recording::Error>(module, "StackError");
  module.def("stack_window", &stack_window, py::kw_only(), py::arg("t_us"), py::arg("x"), py::arg("y"),
             py::arg("motion_t_us"), py::arg("velocity_m_s"), py::arg("rate_rad_s"), py::arg("camera"),
             py::arg("distortion"), py::arg("coefficients"), py::arg("ladder"), py::arg("max_events"),
             py::arg("crop") = Rectangle{0, 0, 0, 0}, py::arg("wanted"), py::arg("maps") = std::nullopt,
             "One window: times count back from its end. wanted: counts, half, cells, focus, context (of "
             "maps), argmax, "
             "sgm, event_mask.");
  module.def(
      "keep_rays", [](std::size_t bytes) { ray_cache().keep(bytes); }, py::arg("bytes"),
      "How much the tables of cameras seen last may take.");
  module.def("grid_pixels", &grid_pixels, py::kw_only(), py::arg("camera"), py::arg("distortion"),
             py::arg("coefficients"), py::arg("crop") = Rectangle{0, 0, 0, 0},
             "For each pixel of the sensor the crop's pixel that its undistorted ray is nearest to, row by "
             "row; -1: none.");
  module.def("focus_input", &focus_input, py::kw_only(), py::arg("planes"), py::arg("hypotheses"),
             py::arg("grid"), py::arg("baseline_m"), py::arg("step_per_m"), py::arg("maps"),
             py::arg("threads") = 1, "(focus, context) of planes of counts [used, height, width].");
  py::class_<Recording>(module, "Recording")
      .def(py::init<const std::string&, const std::optional<std::string>&, const std::optional<Ladder>&>(),
           py::arg("folder"), py::arg("source") = std::nullopt, py::arg("ladder") = std::nullopt)
      .def("tick", &Recording::tick, py::arg("t_us"), py::arg("wanted"), py::arg("maps") = std::nullopt)
      .def("truth_times_us", &Recording::truth_times_us)
      .def("truth_m", &Recording::truth_m, py::arg("t_us"))
      .def("events", &Recording::events, py::arg("tick_us"))
      .def("motion", &Recording::motion, py::arg("tick_us"))
      .def("grid_pixels", &Recording::grid_pixels);
}
