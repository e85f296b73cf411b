#include "recording/replay.hpp"

#include <chrono>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commands.hpp"
#include "kernels/isa.hpp"
#include "noise_options.hpp"
#include "pipeline/embedded_model.hpp"
#include "recording/error.hpp"
#include "recording/model_file.hpp"
#include "recording/png_io.hpp"
#include "recording/progress.hpp"
#include "recording/text_file.hpp"
#include "replay_pictures.hpp"
#include "replay_report.hpp"

namespace egofocus::app {

using recording::Json;
using recording::Progress;

namespace {

struct Arguments {
  std::string recording;
  std::optional<double> rate_hz;
  std::optional<std::int64_t> first_tick_us;
  std::optional<std::int64_t> max_ticks;
  std::string backend;
  std::string model;
  std::optional<FocusCost> cost;
  std::optional<MotionSource> motion;
  std::optional<int> threads;
  VelocityNoise noise;
  std::string isa;
  std::string out;
  std::string golden;
  bool no_smoothing = false;
  bool with_focus = false;
  bool json = false;
};

std::uint32_t mask_up_to(const std::string& name) {
  for (const Isa isa : kEveryIsa) {
    if (name != isa_name(isa)) continue;
    if (!has_isa(detect_isa(), isa)) {
      throw recording::Error(recording::ExitCode::kUsage, "--isa",
                             "this machine has no " + name + ". Leave --isa out to take the best it has.");
    }
    return 2 * isa_bit(isa) - 1;
  }
  throw recording::Error(recording::ExitCode::kUsage, "--isa", "unknown instruction set " + name + ".");
}

// What was asked for is never ignored: an option of one backend chooses it, or contradicts --backend.
Backend backend_of(const Arguments& arguments) {
  const auto refuse = [](const char* option, const char* why) {
    throw recording::Error(recording::ExitCode::kUsage, option, why);
  };
  const bool of_focus = arguments.cost || arguments.no_smoothing;
  Backend backend = of_focus ? Backend::kFocus : default_backend();
  if (!arguments.model.empty()) backend = Backend::kNetwork;
  if (!arguments.backend.empty())
    backend = arguments.backend == "network" ? Backend::kNetwork : Backend::kFocus;
  if (backend == Backend::kFocus) {
    if (!arguments.model.empty()) refuse("--model", "is for --backend network alone.");
    if (arguments.with_focus)
      refuse("--with-focus", "is for --backend network: there is no other one beside.");
    return backend;
  }
  if (of_focus) refuse("--cost, --no-smoothing", "are for --backend focus alone.");
  if (arguments.model.empty() && embedded_model().empty())
    refuse("--backend network", "needs --model FILE: this build embeds no model.");
  return backend;
}

recording::Folder folder_of(const Arguments& arguments, Backend backend) {
  recording::Folder folder = recording::open_folder(arguments.recording, arguments.motion);
  Config& config = folder.camera.config;
  config.backend = backend;
  if (arguments.rate_hz) config.rate.rate_hz = *arguments.rate_hz;
  if (arguments.cost) config.focus.cost = *arguments.cost;
  if (arguments.threads) config.threads = *arguments.threads;
  if (arguments.no_smoothing) config.focus.smoothing = false;
  config.velocity_noise = arguments.noise;
  if (!arguments.isa.empty()) config.isa_mask = mask_up_to(arguments.isa);
  return folder;
}

/// A replay and what is told of it.
struct Told {
  explicit Told(recording::Folder folder) : replay(std::move(folder)) {}

  bool tick() {
    const auto begin = std::chrono::steady_clock::now();
    if (!replay.tick(frame)) return false;
    const std::chrono::duration<double, std::milli> spent = std::chrono::steady_clock::now() - begin;
    report.add(frame, spent.count());
    if (frame.hypotheses > 0) report.add_stages(replay.engine().health().stages);
    return true;
  }

  recording::Replay replay;
  ReplayReport report;
  DepthFrame frame;
};

void run(const Arguments& arguments) {
  const Backend backend = backend_of(arguments);
  recording::Folder folder = folder_of(arguments, backend);
  std::optional<recording::ModelFile> model;  // outlives the replay
  if (!arguments.model.empty()) {
    model.emplace(arguments.model);
    folder.camera.config.model = model->bytes();
  }
  Told told(std::move(folder));
  recording::Replay& replay = told.replay;
  const DepthFrame& frame = told.frame;
  std::optional<Told> beside;
  if (arguments.with_focus) beside.emplace(folder_of(arguments, Backend::kFocus));

  std::optional<ReplayPictures> pictures;
  if (!arguments.out.empty()) pictures.emplace(arguments.out, replay.config().ladder.z_near_m);
  const std::int64_t first_us = arguments.first_tick_us.value_or(replay.default_first_tick_us());
  if (first_us > replay.last_event_us()) {
    throw recording::Error(
        recording::ExitCode::kNoEvents, "--first-tick-us " + std::to_string(first_us),
        "the last event is at " + std::to_string(replay.last_event_us()) + " us. Choose an earlier tick.");
  }
  replay.start(first_us);
  if (beside) beside->replay.start(first_us);

  Progress progress("replay");
  const auto span_us = static_cast<std::size_t>(replay.last_event_us() - first_us + 1);
  const std::int64_t most = arguments.max_ticks.value_or(std::numeric_limits<std::int64_t>::max());
  std::int64_t before_us = std::numeric_limits<std::int64_t>::min();
  for (std::int64_t tick = 0; tick < most && told.tick() && (!beside || beside->tick()); ++tick) {
    std::vector<float> truth_m;
    const recording::DepthTruth* truth = replay.folder().truth_at(frame.t_us);
    if (truth != nullptr && recording::png_available()) {
      truth_m = recording::read_depth(*truth, replay.folder().camera).pixels;
      told.report.add_truth(recording::frame_error(frame, truth_m));
      if (beside) beside->report.add_truth(recording::frame_error(beside->frame, truth_m));
    }
    if (pictures) {
      pictures->write(frame, beside ? &beside->frame : nullptr, replay.config().camera.intrinsics,
                      replay.events_between(before_us, frame.t_us), truth_m);
    }
    before_us = frame.t_us;
    progress.show(static_cast<std::size_t>(frame.t_us - first_us) + 1, span_us);
  }

  recording::check_motion(replay);

  Json summary = told.report.summary(replay, beside ? &beside->report : nullptr);
  if (pictures) {
    const std::filesystem::path out = arguments.out;
    pictures->write_overview();
    summary.add("pictures", arguments.out).add("look_at_first", (out / "overview.png").string());
    recording::write_text_file(out / "report.json", summary.json() + "\n");
  }
  if (!arguments.golden.empty())
    recording::write_text_file(arguments.golden, told.report.golden_text(replay));
  std::puts((arguments.json ? summary.json() : summary.text()).c_str());
}

}  // namespace

void add_replay(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("replay", "run a recording through the engine: one depth map per tick");
  auto a = std::make_shared<Arguments>();
  command->add_option("RECORDING", a->recording, "recording folder (see docs/formats.md)")->required();
  command->add_option("--rate", a->rate_hz, "ticks per second (default: camera.toml)");
  command->add_option(
      "--first-tick-us", a->first_tick_us,
      "time of the first tick (default: first depth truth, or one period after the first event)");
  command->add_option("--ticks", a->max_ticks, "stop after so many ticks")->check(CLI::PositiveNumber);
  command
      ->add_option("--backend", a->backend,
                   "where depth comes from: network (default where a model is embedded), focus")
      ->check(CLI::IsMember({"focus", "network"}));
  command->add_option("--model", a->model, "network: the model file (.efm; default: the embedded model)");
  command->add_flag("--with-focus", a->with_focus,
                    "network: the focus backend beside it, in the report and the pictures");
  const std::map<std::string, FocusCost> costs{{"gradient", FocusCost::kGradient},
                                               {"variance", FocusCost::kVariance},
                                               {"sosa", FocusCost::kSosa},
                                               {"soe", FocusCost::kSoe},
                                               {"sti", FocusCost::kSti}};
  command
      ->add_option("--cost", a->cost,
                   "focus: its cost: gradient, variance, sosa, soe, sti (default: camera.toml)")
      ->transform(CLI::CheckedTransformer(costs).description(""));
  const std::map<std::string, MotionSource> sources{{"odometry", MotionSource::kOdometry},
                                                    {"poses", MotionSource::kPoses}};
  command->add_option("--motion", a->motion, "motion source: odometry, poses (default: camera.toml)")
      ->transform(CLI::CheckedTransformer(sources).description(""));
  command->add_flag("--no-smoothing", a->no_smoothing, "focus: argmax alone, without semi-global smoothing");
  command->add_option("--threads", a->threads, "workers, 1..8; the result is the same");
  command->add_option(
      "--isa", a->isa,
      "no better instruction set than scalar, sse41, avx2, avxvnni, avx512, avx512vnni, neon, "
      "neondot, neonmm; the result is the same");
  add_noise_options(*command, a->noise);
  command->add_option(
      "--out", a->out,
      "folder for pictures and report.json, which comes last: without it the replay did not end");
  command->add_option("--golden", a->golden,
                      "write the machine-independent text (hash per frame, counts, health) here");
  command->add_flag("--json", a->json, "summary as JSON");
  command->footer(
      "Examples:\n"
      "  egofocus replay fixtures/planes --out out/planes\n"
      "  egofocus replay out/slider --first-tick-us 174156 --cost variance --json\n"
      "tick_ms is the time of one tick on this machine: ingest, ego-motion, warp, backend, depth;\n"
      "event_to_depth_ms counts from the newest event that the depth rests on.");
  command->callback([a] { run(*a); });
}

}  // namespace egofocus::app
