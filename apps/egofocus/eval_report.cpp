#include "eval_report.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "noise_options.hpp"
#include "percentiles_json.hpp"

namespace egofocus::app {
namespace {

using recording::MethodScore;
using recording::Metric;
using recording::Metrics;
using recording::PixelSet;
using recording::SequenceScore;

struct Column {
  const char* title;
  Metric metric;
};
constexpr Column kColumns[] = {
    {"abs_rel", recording::kAbsRel},
    {"sq_rel", recording::kSqRel},
    {"rmse", recording::kRmse},
    {"rmse_log", recording::kRmseLog},
    {"d1", recording::kD1},
    {"d2", recording::kD2},
    {"d3", recording::kD3},
    {"epe", recording::kEpe},
    {"<10m", recording::kMae10m},
    {"<20m", recording::kMae20m},
    {"<30m", recording::kMae30m},
    {"idx_mae", recording::kIndexMae},
    {"p.abs", recording::kPaperAbsRel},
    {"p.sq", recording::kPaperSqRel},
    {"p.rmse", recording::kPaperRmse},
    {"p.zero", recording::kPaperZeroShare},
};
constexpr Column kNoiseColumns[] = {
    {"abs_rel", recording::kAbsRel}, {"rmse", recording::kRmse},        {"rmse_log", recording::kRmseLog},
    {"d1", recording::kD1},          {"<10m", recording::kMae10m},      {"<20m", recording::kMae20m},
    {"<30m", recording::kMae30m},    {"idx_mae", recording::kIndexMae},
};

struct Section {
  PixelSet set;
  const char* title;
};
constexpr Section kAllSections[] = {
    {recording::kAll, "all pixels; no estimate counts as the far end of the clip"},
    {recording::kAllCommon, "all pixels where every method has an estimate"},
    {recording::kAllInLadder, "all pixels inside the ladder"}};
constexpr Section kEventSections[] = {
    {recording::kEvents, "event pixels; no estimate counts as the far end of the clip"},
    {recording::kEventsCommon, "event pixels where every method has an estimate"},
    {recording::kEventsInLadder, "event pixels inside the ladder"}};

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[400];
  va_list arguments;
  va_start(arguments, pattern);
  std::vsnprintf(text, sizeof text, pattern, arguments);
  va_end(arguments);
  return text;
}

std::string cell(double value) {
  if (!std::isfinite(value)) return format(" %8s", "-");
  return format(std::abs(value) < 100 ? " %8.4f" : " %8.1f", value);
}

double coverage(const MethodScore& method, PixelSet set) {
  const bool events =
      set == recording::kEvents || set == recording::kEventsInLadder || set == recording::kEventsCommon;
  return (events ? method.events_coverage : method.coverage).value();
}

std::string table(const SequenceScore& score, const Section& section) {
  std::string text = format("\n%s\n%-13s %6s %8s", section.title, "method", "images", "coverage");
  for (const Column& column : kColumns) text += format(" %8s", column.title);
  for (const MethodScore& method : score.methods) {
    text += format("\n%-13s %6zu", method.method.c_str(), method.sets[section.set].count());
    text += cell(coverage(method, section.set));
    const Metrics mean = method.sets[section.set].mean();
    for (const Column& column : kColumns) text += cell(mean[column.metric]);
  }
  return text + "\n";
}

std::string confidence_table(const SequenceScore& score) {
  std::string text;
  for (const MethodScore& method : score.methods) {
    if (method.sparsification.images() == 0) continue;
    if (text.empty()) {
      text = "\nconfidence: abs_rel of all pixels with an estimate, when the least confident are removed\n";
      text += format("%-13s %6s %8s %8s %8s %8s %8s %8s %8s %8s", "method", "images", "none", "25%", "50%",
                     "75%", "95%", "area", "oracle", "ause");
    }
    const recording::Sparsification mean = method.sparsification.mean();
    text += format("\n%-13s %6zu", method.method.c_str(), method.sparsification.images());
    for (const std::size_t step : {0u, 5u, 10u, 15u, 19u}) text += cell(mean.by_confidence[step]);
    const double area = recording::area_under(mean.by_confidence);
    const double oracle = recording::area_under(mean.by_oracle);
    text += cell(area) + cell(oracle) + cell(area - oracle);
  }
  return text.empty() ? text : text + "\n";
}

std::string times_table(const SequenceScore& score) {
  std::string text;
  for (const MethodScore& method : score.methods) {
    if (method.times.ticks() == 0) continue;
    if (text.empty()) {
      text = "\ntime on this machine in ms: of a tick; from the newest event to the depth that rests on it\n";
      text += format("%-13s %6s %8s %8s %8s %8s %8s %8s", "method", "ticks", "p50", "p99", "max", "p50",
                     "p99", "max");
    }
    text += format("\n%-13s %6zu", method.method.c_str(), method.times.ticks());
    for (const recording::Percentiles& p : {method.times.tick_ms(), method.times.event_to_depth_ms()})
      text += cell(p.p50) + cell(p.p99) + cell(p.max);
  }
  return text.empty() ? text : text + "\n";
}

Json metrics_json(const recording::MetricMeans& means) {
  Json json;
  json.add("images", means.count());
  const Metrics mean = means.mean();
  for (std::size_t i = 0; i < recording::kMetrics; ++i) json.add(recording::kMetricNames[i], mean[i]);
  return json;
}

Json method_json(const MethodScore& method) {
  Json json;
  json.add("method", method.method)
      .add("images_with_estimate", method.images_with_estimate)
      .add("coverage", method.coverage.value())
      .add("events_coverage", method.events_coverage.value());
  for (std::size_t set = 0; set < recording::kPixelSets; ++set)
    json.add(recording::kPixelSetNames[set], metrics_json(method.sets[set]));
  if (method.times.ticks() > 0) {
    json.add("tick_ms", percentiles_json(method.times.tick_ms()))
        .add("event_to_depth_ms", percentiles_json(method.times.event_to_depth_ms()));
  }
  if (method.sparsification.images() == 0) return json;
  const recording::Sparsification mean = method.sparsification.mean();
  const double area = recording::area_under(mean.by_confidence);
  const double oracle = recording::area_under(mean.by_oracle);
  return json.add("sparsification", Json()
                                        .add("images", method.sparsification.images())
                                        .add("by_confidence", std::span<const double>(mean.by_confidence))
                                        .add("by_oracle", std::span<const double>(mean.by_oracle))
                                        .add("area", area)
                                        .add("oracle_area", oracle)
                                        .add("ause", area - oracle));
}

Json image_json(const recording::ImageFact& image) {
  Json json;
  json.add("t_us", image.t_us)
      .add("window_begin_us", image.window_begin_us)
      .add("step_per_m", image.step_per_m)
      .add("hypotheses", image.hypotheses)
      .add("flags", image.flags);
  Json pixels;
  for (std::size_t set = 0; set < recording::kPixelSets; ++set)
    pixels.add(recording::kPixelSetNames[set], image.pixels[set]);
  return json.add("pixels", pixels);
}

}  // namespace

std::string eval_text(const SequenceScore& score, Mask mask) {
  std::string text =
      format("%s: %zu of %zu truth images compared, %zu of them before the first event",
             score.recording.c_str(), score.images.size(), score.truth_images, score.before_events);
  text +=
      format("; %zu after the last event, %zu of the time of another, %zu at no tick, %zu over the limit\n",
             score.after_events, score.same_time, score.without_tick, score.over_limit);
  text += format("%zu images without a ladder", score.images_without_ladder());
  if (std::isfinite(score.outside_ladder()))
    text += format("; of the truth in the others %.2f %% lies outside it", 100 * score.outside_ladder());
  if (score.median_m > 0) text += format("; median of the truth %.3f m", score.median_m);
  text += "\n";
  if (mask != Mask::kEvents) {
    for (const Section& section : kAllSections) text += table(score, section);
  }
  if (mask != Mask::kAll) {
    for (const Section& section : kEventSections) text += table(score, section);
  }
  return text + confidence_table(score) + times_table(score);
}

Json eval_json(const SequenceScore& score, bool images) {
  Json json;
  json.add("recording", score.recording)
      .add("truth_images", score.truth_images)
      .add("compared", score.images.size())
      .add("before_events", score.before_events)
      .add("after_events", score.after_events)
      .add("same_time", score.same_time)
      .add("without_tick", score.without_tick)
      .add("over_limit", score.over_limit)
      .add("images_without_ladder", score.images_without_ladder())
      .add("outside_ladder", score.outside_ladder());
  if (score.median_m > 0) json.add("median_m", score.median_m);
  std::vector<Json> methods;
  for (const MethodScore& method : score.methods) methods.push_back(method_json(method));
  json.add("methods", methods);
  if (!images) return json;
  std::vector<Json> list;
  for (const recording::ImageFact& image : score.images) list.push_back(image_json(image));
  return json.add("images", list);
}

std::string noise_text(const std::vector<NoiseRow>& rows, Mask mask) {
  const VelocityNoise& noise = rows.front().noise;
  std::string text = format("velocity noise, %s, drawn per %s, seed %llu", kind_text(noise), draw_text(noise),
                            static_cast<unsigned long long>(noise.seed));
  for (const PixelSet set : {recording::kAllCommon, recording::kEventsCommon}) {
    if (mask == (set == recording::kAllCommon ? Mask::kEvents : Mask::kAll)) continue;
    for (std::size_t m = 0; m < rows.front().score.methods.size(); ++m) {
      text +=
          format("\n\n%s, %s\n%7s %6s %8s", rows.front().score.methods[m].method.c_str(),
                 set == recording::kAllCommon ? "pixels with an estimate" : "event pixels with an estimate",
                 "percent", "images", "coverage");
      for (const Column& column : kNoiseColumns) text += format(" %8s", column.title);
      for (const NoiseRow& row : rows) {
        const MethodScore& method = row.score.methods[m];
        text += format("\n%7g %6zu", row.noise.percent, method.sets[set].count());
        text += cell(coverage(method, set));
        const Metrics mean = method.sets[set].mean();
        for (const Column& column : kNoiseColumns) text += cell(mean[column.metric]);
      }
    }
  }
  return text + "\n";
}

Json noise_json(const std::vector<NoiseRow>& rows) {
  std::vector<Json> list;
  for (const NoiseRow& row : rows) {
    list.push_back(Json()
                       .add("percent", row.noise.percent)
                       .add("kind", kind_text(row.noise))
                       .add("per", draw_text(row.noise))
                       .add("seed", row.noise.seed)
                       .add("overall", eval_json(row.score, false)));
  }
  return Json().add("noise_study", list);
}

}  // namespace egofocus::app
