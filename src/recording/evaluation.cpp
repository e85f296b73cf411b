#include "recording/evaluation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "recording/error.hpp"
#include "recording/event_mask.hpp"
#include "recording/npy_file.hpp"
#include "recording/output_folder.hpp"
#include "recording/png_io.hpp"

namespace egofocus::recording {
namespace {

namespace fs = std::filesystem;

/// A bit per PixelSet, for each pixel of the grid.
using SetBits = std::vector<std::uint8_t>;

constexpr unsigned bit(PixelSet set) {
  return 1u << set;
}

/// One image: truth, and every method's map of it.
struct Image {
  std::vector<float> truth_m;
  std::vector<std::uint8_t> events;
  std::vector<DepthMap> maps;
};

SetBits pixel_sets(const Image& image, const MetricRange& range, ImageFact& fact) {
  SetBits sets(image.truth_m.size(), 0);
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const double truth = static_cast<double>(image.truth_m[i]);
    if (!range.is_truth(truth)) continue;
    const bool inside = in_ladder(truth, fact.step_per_m, fact.hypotheses);
    const bool common = std::all_of(image.maps.begin(), image.maps.end(),
                                    [i](const DepthMap& map) { return map.depth_m[i] > 0; });
    const unsigned all = bit(kAll) | (inside ? bit(kAllInLadder) : 0u) | (common ? bit(kAllCommon) : 0u);
    const unsigned events =
        bit(kEvents) | (inside ? bit(kEventsInLadder) : 0u) | (common ? bit(kEventsCommon) : 0u);
    sets[i] = static_cast<std::uint8_t>(image.events[i] ? all | events : all);
    for (std::size_t set = 0; set < kPixelSets; ++set) fact.pixels[set] += sets[i] >> set & 1u;
  }
  return sets;
}

void score(const Image& image, const SetBits& sets, const DepthMap& map, const MetricRange& range,
           const ImageFact& fact, MethodScore& out) {
  std::array<MetricMeans, kPixelSets> terms;
  std::vector<JudgedPixel> judged;
  std::size_t known = 0;
  std::size_t known_events = 0;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    if (sets[i] == 0) continue;
    const double estimate = static_cast<double>(map.depth_m[i]);
    const Metrics term = pixel_terms(estimate, static_cast<double>(image.truth_m[i]), range, fact.step_per_m);
    for (std::size_t set = 0; set < kPixelSets; ++set) {
      if (sets[i] >> set & 1u) terms[set].add(term);
    }
    if (!(estimate > 0)) continue;
    ++known;
    known_events += sets[i] >> kEvents & 1u;
    if (!map.confidence.empty()) judged.push_back({term[kAbsRel], map.confidence[i]});
  }
  const auto share = [](std::size_t part, std::size_t all) {
    return static_cast<double>(part) / static_cast<double>(all);
  };
  for (std::size_t set = 0; set < kPixelSets; ++set) {
    if (terms[set].count() > 0) out.sets[set].add(image_metrics(terms[set]));
  }
  if (fact.pixels[kAll] > 0) out.coverage.add(share(known, fact.pixels[kAll]));
  if (fact.pixels[kEvents] > 0) out.events_coverage.add(share(known_events, fact.pixels[kEvents]));
  out.images_with_estimate += known > 0 ? 1 : 0;
  if (!judged.empty()) out.sparsification.add(sparsification(judged));
}

ImageFact compare(const Image& image, const DepthFrame& frame, const MetricRange& range,
                  std::vector<MethodScore>& methods) {
  ImageFact fact;
  fact.t_us = frame.t_us;
  fact.window_begin_us = frame.window_begin_us;
  // A carried map has the scale of another tick's ladder, and no ladder of its own.
  fact.step_per_m = frame.hypotheses > 0 ? frame.inverse_depth_scale_per_m * 256.0 : 0.0;
  fact.hypotheses = frame.hypotheses;
  fact.flags = frame.flags;
  const SetBits sets = pixel_sets(image, range, fact);
  for (std::size_t m = 0; m < methods.size(); ++m) score(image, sets, image.maps[m], range, fact, methods[m]);
  return fact;
}

void write_image(const OutputFolder& out, const std::vector<std::string>& methods, const Image& image,
                 const Intrinsics& grid, const std::string& stem) {
  const auto folder = [&out](const std::string& name) {
    std::error_code error;
    fs::create_directories(out / name, error);
    if (error) throw Error(ExitCode::kFile, (out / name).string(), "cannot be made: " + error.message());
    return out / name;
  };
  const auto write = [&grid](const fs::path& path, auto picture, const auto& pixels) {
    picture.width_px = grid.width_px;
    picture.height_px = grid.height_px;
    picture.pixels = pixels;
    write_npy(path, picture);
  };
  write(folder("events") / (stem + ".npy"), GreyPicture(), image.events);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    const fs::path of_method = folder(methods[m]);
    write(of_method / (stem + ".npy"), Picture<float>(), image.maps[m].depth_m);
    if (!image.maps[m].confidence.empty())
      write(of_method / (stem + "_confidence.npy"), GreyPicture(), image.maps[m].confidence);
  }
}

/// The truth to compare with, at most max_images of it; the rest is counted.
std::vector<DepthTruth> plan(const Replay& replay, const std::optional<TickGrid>& grid,
                             std::size_t max_images, SequenceScore& counts) {
  const std::vector<DepthTruth>& truth = replay.folder().truth;
  const std::string where = (replay.folder().path / "depth").string();
  if (truth.empty())
    throw Error(ExitCode::kFile, where, "holds no depth pictures: there is no truth to compare with.");
  counts.truth_images = truth.size();
  std::vector<DepthTruth> planned = plan_truth(truth, grid, replay.last_event_us(), counts);
  const std::string none = "none of the " + std::to_string(truth.size()) + " depth pictures ";
  if (planned.empty() && counts.without_tick == 0) {
    throw Error(ExitCode::kNoEvents, where,
                none + "is before the last event, at " + std::to_string(replay.last_event_us()) +
                    " us. Are their names and the events on one clock?");
  }
  if (planned.empty()) {
    throw Error(ExitCode::kUsage, where,
                none + "is of a tick (" + std::to_string(grid->rate_hz) + " Hz from " +
                    std::to_string(grid->first_us) +
                    " us). Leave --rate and --first-tick-us out to tick at the pictures' times.");
  }
  if (planned.size() > max_images) {
    counts.over_limit = planned.size() - max_images;
    planned.resize(max_images);
  }
  return planned;
}

double median_of(const std::vector<DepthTruth>& truth, const CameraFile& camera, const MetricRange& range) {
  TruthMedian median;
  for (const DepthTruth& item : truth) median.add(read_depth(item, camera), range);
  return median.median_m();
}

}  // namespace

bool in_ladder(double truth_m, double step_per_m, std::int32_t hypotheses) {
  if (!(step_per_m > 0)) return false;
  const double index = 1.0 / truth_m / step_per_m;
  return index >= 0.5 && index <= hypotheses - 1;
}

bool TickGrid::has(std::int64_t t_us) const {
  const double k = std::round((static_cast<double>(t_us) - static_cast<double>(first_us)) * rate_hz / 1e6);
  if (!(k >= 0 && k < 0x1p53)) return false;
  const double offset_us = std::floor(k * 1e6 / rate_hz);
  return offset_us < 0x1p62 && t_us - static_cast<std::int64_t>(offset_us) == first_us;
}

std::vector<DepthTruth> plan_truth(const std::vector<DepthTruth>& truth, const std::optional<TickGrid>& grid,
                                   std::int64_t last_event_us, SequenceScore& counts) {
  std::vector<DepthTruth> planned;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::int64_t t_us = truth[i].t_us;
    if (t_us > last_event_us) {
      ++counts.after_events;
    } else if (i > 0 && t_us == truth[i - 1].t_us) {
      ++counts.same_time;
    } else if (grid && !grid->has(t_us)) {
      ++counts.without_tick;
    } else {
      planned.push_back(truth[i]);
    }
  }
  return planned;
}

SequenceScore evaluate(const fs::path& recording, const EvalOptions& options) {
  if (!png_available())
    throw Error(ExitCode::kUsage, "eval", "this build has no libpng. Install libpng-dev and build again.");
  std::vector<EvalMethod> methods;
  for (const std::string& name : options.methods) methods.emplace_back(name, recording, options);
  const auto has_engine = [](const EvalMethod& method) { return method.replay() != nullptr; };
  // Behind the compared ones, where none of them has an engine.
  if (std::none_of(methods.begin(), methods.end(), has_engine))
    methods.emplace_back("focus", recording, options);
  const EvalMethod& leader = *std::find_if(methods.begin(), methods.end(), has_engine);

  Replay& replay = *leader.replay();
  const CameraFile& camera = replay.folder().camera;
  std::optional<TickGrid> tick_grid;
  if (options.on_grid) {
    tick_grid = {options.first_tick_us.value_or(replay.default_first_tick_us()),
                 replay.config().rate.rate_hz};
  }
  SequenceScore result;
  result.recording = recording_name(recording);
  const std::vector<DepthTruth> planned = plan(replay, tick_grid, options.max_images, result);
  result.median_m = median_of(planned, camera, options.range);
  result.methods.resize(options.methods.size());
  for (std::size_t i = 0; i < options.methods.size(); ++i) {
    result.methods[i].method = options.methods[i];
    if (options.methods[i] == "median") methods[i].set_constant(result.median_m);
  }

  std::optional<OutputFolder> out;
  if (!options.out.empty()) out.emplace(options.out / result.recording).create();
  EventMask event_mask(camera.config);
  std::int64_t before_us = std::numeric_limits<std::int64_t>::min();
  for (EvalMethod& method : methods) method.start(tick_grid ? tick_grid->first_us : planned.front().t_us);
  while (result.images.size() < planned.size()) {
    bool has_frame = true;
    for (EvalMethod& method : methods) {
      if (!tick_grid) method.set_next_tick(planned[result.images.size()].t_us);
      has_frame = method.tick() && has_frame;
    }
    if (!has_frame) break;
    const DepthFrame& frame = leader.frame();
    event_mask.add(replay.events_between(before_us, frame.t_us));
    before_us = frame.t_us;
    const DepthTruth& truth = planned[result.images.size()];
    if (frame.t_us != truth.t_us) continue;
    Image image;
    image.truth_m = read_depth(truth, camera).pixels;
    image.events = event_mask.since(frame.window_begin_us);
    for (std::size_t m = 0; m < options.methods.size(); ++m)
      image.maps.push_back(methods[m].map(truth, camera));
    result.images.push_back(compare(image, frame, options.range, result.methods));
    result.before_events += frame.t_us < replay.first_event_us() ? 1 : 0;
    if (out) write_image(*out, options.methods, image, frame.grid, truth.path.stem().string());
    options.progress(result.images.size(), planned.size());
  }
  check_motion(replay);
  for (std::size_t m = 0; m < result.methods.size(); ++m) result.methods[m].times = methods[m].times();
  if (out) out->finish();
  result.without_tick += planned.size() - result.images.size();
  return result;
}

std::size_t SequenceScore::images_without_ladder() const {
  return static_cast<std::size_t>(std::count_if(
      images.begin(), images.end(), [](const ImageFact& image) { return !(image.step_per_m > 0); }));
}

double SequenceScore::outside_ladder() const {
  std::size_t all = 0;
  std::size_t inside = 0;
  for (const ImageFact& image : images) {
    if (!(image.step_per_m > 0)) continue;
    all += image.pixels[kAll];
    inside += image.pixels[kAllInLadder];
  }
  return static_cast<double>(all - inside) / static_cast<double>(all);
}

SequenceScore overall(const std::vector<SequenceScore>& sequences) {
  SequenceScore all;
  all.recording = "overall";
  for (const SequenceScore& sequence : sequences) {
    all.truth_images += sequence.truth_images;
    all.after_events += sequence.after_events;
    all.same_time += sequence.same_time;
    all.without_tick += sequence.without_tick;
    all.over_limit += sequence.over_limit;
    all.before_events += sequence.before_events;
    all.images.insert(all.images.end(), sequence.images.begin(), sequence.images.end());
    all.methods.resize(sequence.methods.size());
    for (std::size_t m = 0; m < all.methods.size(); ++m) {
      MethodScore& sum = all.methods[m];
      const MethodScore& one = sequence.methods[m];
      sum.method = one.method;
      for (std::size_t set = 0; set < kPixelSets; ++set) sum.sets[set].add(one.sets[set]);
      sum.coverage.add(one.coverage);
      sum.events_coverage.add(one.events_coverage);
      sum.images_with_estimate += one.images_with_estimate;
      sum.sparsification.add(one.sparsification);
      sum.times.add(one.times);
    }
  }
  return all;
}

}  // namespace egofocus::recording
