#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "commands.hpp"
#include "eval_curve.hpp"
#include "eval_report.hpp"
#include "noise_options.hpp"
#include "recording/depth_prior.hpp"
#include "recording/error.hpp"
#include "recording/evaluation.hpp"
#include "recording/output_folder.hpp"
#include "recording/progress.hpp"
#include "recording/text_file.hpp"

namespace egofocus::app {

using recording::Json;
using recording::Progress;

namespace {

using recording::Error;
using recording::EvalOptions;
using recording::ExitCode;
using recording::SequenceScore;

// The paper's rows.
constexpr double kStudyPercents[] = {0, 10, 20, 50, 100};

struct Arguments {
  std::vector<std::string> recordings;
  std::vector<std::string> methods;
  double cut_m = 80;
  std::string clip;
  Mask mask = Mask::kBoth;
  int min_confidence = 1;
  std::optional<std::size_t> limit;
  std::string maps;
  std::string model;
  std::string prior;
  std::string fit_prior;
  std::string out;
  std::string json;
  std::string curve;
  std::optional<double> rate_hz;
  std::optional<std::int64_t> first_tick_us;
  std::optional<FocusCost> cost;
  std::optional<MotionSource> motion;
  std::optional<int> threads;
  VelocityNoise noise;
  bool noise_study = false;
};

recording::MetricRange range_of(const Arguments& arguments) {
  recording::MetricRange range;
  range.cut_m = arguments.cut_m;
  range.clip_max_m = arguments.cut_m;
  if (arguments.clip.empty()) return range;
  int used = 0;
  if (std::sscanf(arguments.clip.c_str(), "%lf:%lf%n", &range.clip_min_m, &range.clip_max_m, &used) != 2 ||
      static_cast<std::size_t>(used) != arguments.clip.size() || !(range.clip_min_m > 0) ||
      !(range.clip_max_m > range.clip_min_m) || !std::isfinite(range.clip_max_m)) {
    throw Error(ExitCode::kUsage, "--clip", "must be two depths in metres that rise, such as 0.1:80.");
  }
  return range;
}

std::vector<std::string> methods_of(const Arguments& arguments) {
  if (arguments.methods.empty()) {
    std::vector<std::string> methods{"focus", "focus+sgm"};
    if (!arguments.model.empty() || default_backend() == Backend::kNetwork) methods.push_back("network");
    if (arguments.noise_study) return methods;
    methods.push_back("median");
    if (!arguments.prior.empty()) methods.insert(methods.end(), {"median-prior", "rows"});
    if (!arguments.maps.empty()) methods.push_back("maps");
    return methods;
  }
  if (std::set<std::string>(arguments.methods.begin(), arguments.methods.end()).size() !=
      arguments.methods.size())
    throw Error(ExitCode::kUsage, "--methods", "names a method twice.");
  return arguments.methods;
}

EvalOptions options_of(const Arguments& arguments) {
  EvalOptions options;
  options.methods = methods_of(arguments);
  options.range = range_of(arguments);
  options.min_confidence = arguments.min_confidence;
  if (arguments.limit) options.max_images = *arguments.limit;
  if (!arguments.prior.empty()) options.prior = recording::read_prior(arguments.prior);
  options.maps = arguments.maps;
  options.model = arguments.model;
  options.out = arguments.out;
  options.motion = arguments.motion;
  options.on_grid = arguments.rate_hz || arguments.first_tick_us;
  options.first_tick_us = arguments.first_tick_us;
  options.adjust = [&arguments, noise = arguments.noise](Config& config) {
    if (arguments.rate_hz) config.rate.rate_hz = *arguments.rate_hz;
    if (arguments.cost) config.focus.cost = *arguments.cost;
    if (arguments.threads) config.threads = *arguments.threads;
    config.velocity_noise = noise;
  };
  return options;
}

/// Folders of maps carry the recordings' names. What stands in the way of one is said before any work.
void check_names(const Arguments& arguments) {
  std::set<std::string> names;
  for (const std::string& path : arguments.recordings) {
    const std::string name = recording::recording_name(path);
    if (!names.insert(name).second && !(arguments.out.empty() && arguments.maps.empty())) {
      throw Error(ExitCode::kUsage, path,
                  "two recordings are named " + name + "; --out and --maps tell them apart by this name.");
    }
    if (!arguments.out.empty())
      static_cast<void>(recording::OutputFolder(std::filesystem::path(arguments.out) / name));
  }
}

std::vector<SequenceScore> evaluate_all(const Arguments& arguments, EvalOptions options) {
  std::vector<SequenceScore> scores;
  for (const std::string& path : arguments.recordings) {
    Progress progress("eval " + recording::recording_name(path));
    options.progress = [&progress](std::size_t done, std::size_t all) { progress.show(done, all); };
    scores.push_back(recording::evaluate(path, options));
  }
  return scores;
}

void fit_prior(const Arguments& arguments) {
  const recording::MetricRange range = range_of(arguments);
  recording::DepthPriorFit fit;
  for (const std::string& path : arguments.recordings) {
    const recording::Folder folder = recording::open_folder(path, arguments.motion);
    Progress progress("fit " + recording::recording_name(path));
    const std::size_t count = std::min(folder.truth.size(), arguments.limit.value_or(SIZE_MAX));
    for (std::size_t i = 0; i < count; ++i) {
      fit.add(recording::read_depth(folder.truth[i], folder.camera), range);
      progress.show(i + 1, count);
    }
  }
  const recording::DepthPrior prior = fit.result();
  recording::write_prior(arguments.fit_prior, prior);
  std::printf("%s: %zu images, median %.3f m, rows %.3f m (top) to %.3f m (bottom)\n",
              arguments.fit_prior.c_str(), prior.images, prior.median_m, prior.row_depth_m.front(),
              prior.row_depth_m.back());
}

void write_json(const std::string& path, const Json& json) {
  if (!path.empty()) recording::write_text_file(path, json.json() + "\n");
}

void study_noise(const Arguments& arguments, const EvalOptions& base) {
  std::vector<NoiseRow> rows;
  for (const double percent : kStudyPercents) {
    Arguments one = arguments;
    one.noise.percent = percent;
    EvalOptions options = options_of(one);
    options.methods = base.methods;
    rows.push_back({one.noise, recording::overall(evaluate_all(one, options))});
  }
  std::fputs(noise_text(rows, arguments.mask).c_str(), stdout);
  write_json(arguments.json, noise_json(rows));
}

void run(const Arguments& arguments) {
  if (!arguments.fit_prior.empty()) return fit_prior(arguments);
  check_names(arguments);
  const EvalOptions options = options_of(arguments);
  if (arguments.noise_study) return study_noise(arguments, options);
  const std::vector<SequenceScore> scores = evaluate_all(arguments, options);
  std::string text;
  std::vector<Json> sequences;
  for (const SequenceScore& score : scores) {
    text += (text.empty() ? "" : "\n") + eval_text(score, arguments.mask);
    sequences.push_back(eval_json(score, true));
  }
  const SequenceScore all = recording::overall(scores);
  if (scores.size() > 1) text += "\n" + eval_text(all, arguments.mask);
  std::fputs(text.c_str(), stdout);
  if (!arguments.curve.empty()) recording::write_text_file(arguments.curve, curve_svg(all));
  write_json(arguments.json, Json()
                                 .add("cut_m", options.range.cut_m)
                                 .add("clip_min_m", options.range.clip_min_m)
                                 .add("clip_max_m", options.range.clip_max_m)
                                 .add("min_confidence", options.min_confidence)
                                 .add("velocity_noise_percent", arguments.noise.percent)
                                 .add("noise_kind", kind_text(arguments.noise))
                                 .add("noise_per", draw_text(arguments.noise))
                                 .add("seed", arguments.noise.seed)
                                 .add("recordings", sequences)
                                 .add("overall", eval_json(all, false)));
}

void add_engine_options(CLI::App& command, Arguments& a) {
  command.add_option(
      "--rate", a.rate_hz,
      "so many ticks per second, and compare only truth at a tick's very time (default: tick at "
      "the truth's times)");
  command.add_option("--first-tick-us", a.first_tick_us,
                     "the same with the first tick there, at the rate of camera.toml or --rate (default with "
                     "--rate: first depth truth)");
  const std::map<std::string, FocusCost> costs{{"gradient", FocusCost::kGradient},
                                               {"variance", FocusCost::kVariance},
                                               {"sosa", FocusCost::kSosa},
                                               {"soe", FocusCost::kSoe},
                                               {"sti", FocusCost::kSti}};
  command
      .add_option("--cost", a.cost, "focus cost: gradient, variance, sosa, soe, sti (default: camera.toml)")
      ->transform(CLI::CheckedTransformer(costs).description(""));
  const std::map<std::string, MotionSource> sources{{"odometry", MotionSource::kOdometry},
                                                    {"poses", MotionSource::kPoses}};
  command.add_option("--motion", a.motion, "motion source: odometry, poses (default: camera.toml)")
      ->transform(CLI::CheckedTransformer(sources).description(""));
  command.add_option("--threads", a.threads, "workers, 1..8; the result is the same");
  add_noise_options(command, a.noise);
  command.add_flag("--noise-study", a.noise_study,
                   "the methods with an engine at 0, 10, 20, 50 and 100 % of velocity noise, one row each");
}

}  // namespace

void add_eval(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "eval", "compare depth with the truth of recordings: all metrics, next to what needs no camera");
  auto a = std::make_shared<Arguments>();
  command->add_option("RECORDING", a->recordings, "recording folders with depth/*.png")->required();
  command
      ->add_option("--methods", a->methods,
                   "of focus, focus+sgm, network, median, median-prior, rows, maps; default: all that have "
                   "their input")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(recording::kMethodNames));
  command->add_option("--cut", a->cut_m, "truth beyond so many metres does not count")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--clip", a->clip, "estimates are clipped to MIN:MAX metres (default: 0.1:CUT)");
  const std::map<std::string, Mask> masks{{"all", Mask::kAll}, {"events", Mask::kEvents}};
  command->add_option("--mask", a->mask, "print only these pixels: all, events (default: both)")
      ->transform(CLI::CheckedTransformer(masks).description(""));
  command->add_option("--min-confidence", a->min_confidence, "less than this is no estimate; 1..255")
      ->check(CLI::Range(1, 255))
      ->capture_default_str();
  command->add_option("--limit", a->limit, "the first so many images of each recording")
      ->check(CLI::PositiveNumber);
  command->add_option("--maps", a->maps,
                      "depth pictures to compare, named and scaled like the truth: DIR/<recording>/*.png or, "
                      "for one recording, DIR/*.png");
  command->add_option("--model", a->model,
                      "model file (.efm) of the method network (default: the embedded one)");
  command->add_option("--prior", a->prior, "file of --fit-prior; adds the methods median-prior and rows");
  command->add_option("--fit-prior", a->fit_prior, "write such a file from the recordings, and do no more");
  command->add_option("--out", a->out, "folder for every map, confidence and event mask as .npy");
  command->add_option("--json", a->json, "write every number here");
  command->add_option("--curve", a->curve, "write the confidence's curve here, an SVG picture");
  add_engine_options(*command, *a);
  // Never ignore what was asked for.
  for (const char* other : {"--velocity-noise", "--out", "--curve"})
    command->get_option("--noise-study")->excludes(command->get_option(other));
  for (const char* other : {"--methods", "--mask", "--min-confidence", "--maps", "--model", "--prior",
                            "--out", "--json", "--curve", "--noise-study", "--velocity-noise"})
    command->get_option("--fit-prior")->excludes(command->get_option(other));
  command->footer(
      "Examples:\n"
      "  egofocus eval fixtures/planes --cut 10\n"
      "  egofocus eval --fit-prior prior.toml town1 town3\n"
      "  egofocus eval town4 town5_night --prior prior.toml --json scores.json\n"
      "  egofocus eval town4 --noise-study --seed 7\n"
      "docs/accuracy.md defines each number.");
  command->callback([a] { run(*a); });
}

}  // namespace egofocus::app
