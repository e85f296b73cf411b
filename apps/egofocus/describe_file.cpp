#include <array>
#include <memory>

#include "core/decimal.hpp"
#include "describe.hpp"
#include "describe_model.hpp"
#include "describe_raw.hpp"
#include "hal/candump_decoder.hpp"
#include "hal/dbc.hpp"
#include "hal/text_words.hpp"
#include "recording/camera_toml.hpp"
#include "recording/error.hpp"
#include "recording/mapped_file.hpp"
#include "recording/png_io.hpp"
#include "recording/pose_file.hpp"
#include "recording/text_events.hpp"

namespace egofocus::app {
namespace {

using recording::Error;
using recording::ExitCode;

Json describe_text_events(std::string_view text) {
  const recording::TextEvents read = recording::parse_text_events(text);
  Json facts;
  facts.add("kind", "text events").add("lines", read.lines);
  add_event_facts(read.events, facts);
  facts.add("malformed", read.malformed).add("out_of_order", read.out_of_order).add("blank", read.blank);
  return facts;
}

Json describe_candump(std::span<const std::byte> rest) {
  CandumpDecoder decoder;
  std::array<CanFrame, 256> block;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
  bool any = false;
  for (Decoded step; !rest.empty(); rest = rest.subspan(step.consumed)) {
    step = decoder.finish(rest, block);
    for (std::size_t i = 0; i < step.produced; ++i) {
      if (!any) first_us = last_us = block[i].t_us;
      any = true;
      first_us = std::min(first_us, block[i].t_us);
      last_us = std::max(last_us, block[i].t_us);
    }
    if (step.consumed == 0) break;
  }
  const CandumpCounters& counters = decoder.counters();
  Json facts;
  facts.add("kind", "candump log")
      .add("lines", counters.lines)
      .add("frames", counters.frames)
      .add("first_us", first_us)
      .add("last_us", last_us)
      .add("error_frames", counters.error_frames)
      .add("remote_frames", counters.remote_frames)
      .add("recorder_drops", counters.recorder_drops)
      .add("out_of_order", counters.out_of_order)
      .add("unknown_lines", counters.unknown + counters.over_long);
  return facts;
}

Json describe_dbc(std::string_view text, const std::string& name) {
  const auto dbc = std::make_unique<Dbc>();
  const Status status = read_dbc(text, {}, *dbc);
  if (!status.ok()) {
    char reason[200];
    status.describe(reason);
    throw Error(ExitCode::kBadFile, name, reason);
  }
  std::vector<Json> messages;
  for (std::size_t i = 0; i < dbc->message_count; ++i) {
    const DbcMessage& message = dbc->messages[i];
    std::string signals;
    for (std::size_t k = 0; k < message.signal_count; ++k) {
      signals += (k > 0 ? " " : "") + std::string(dbc->signals[message.first_signal + k].name);
    }
    char id[16];
    std::snprintf(id, sizeof id, message.extended ? "%08X" : "%03X", message.id);
    Json entry;
    entry.add("message", message.name).add("id", id).add("bytes", message.length).add("signals", signals);
    messages.push_back(entry);
  }
  Json facts;
  facts.add("kind", "DBC")
      .add("messages", dbc->message_count)
      .add("signals", dbc->signal_count)
      .add("list", messages);
  return facts;
}

Json describe_poses(std::string_view text, const std::string& name) {
  const std::vector<PoseSample> poses = recording::parse_poses(text, name);
  std::int64_t widest_us = 0;
  for (std::size_t i = 1; i < poses.size(); ++i)
    widest_us = std::max(widest_us, poses[i].t_us - poses[i - 1].t_us);
  Json facts;
  facts.add("kind", "poses").add("poses", poses.size());
  if (!poses.empty()) facts.add("first_us", poses.front().t_us).add("last_us", poses.back().t_us);
  facts.add("widest_gap_us", widest_us);
  return facts;
}

Json describe_camera(std::string_view text, const std::string& name) {
  const recording::CameraFile file = recording::parse_camera_toml(text, name);
  const Intrinsics& camera = file.config.camera.intrinsics;
  Json facts;
  facts.add("kind", "camera.toml")
      .add("width_px", camera.width_px)
      .add("height_px", camera.height_px)
      .add("fx_px", camera.fx_px)
      .add("fy_px", camera.fy_px)
      .add("motion", file.config.motion.source == MotionSource::kPoses ? "poses" : "odometry")
      .add("can_signals", file.can.motion.signal_count)
      .add("rate_hz", file.config.rate.rate_hz);
  return facts;
}

Json describe_png(const std::filesystem::path& path) {
  const recording::PngHeader header = recording::png_header(path);
  Json facts;
  facts.add("kind", "PNG picture")
      .add("width_px", header.width_px)
      .add("height_px", header.height_px)
      .add("bit_depth", header.bit_depth)
      .add("colour", header.colour);
  return facts;
}

/// Numbers in the first line that is neither blank nor a comment; -1 if it holds anything else.
int numbers_in_first_line(std::string_view text) {
  while (!text.empty()) {
    std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    int count = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line), ++count) {
      if (count == 0 && word.front() == '#') break;
      Decimal number;
      if (scan_decimal(word, number) != word.size()) return -1;
    }
    if (count > 0) return count;
  }
  return -1;
}

}  // namespace

Json describe_file(const std::filesystem::path& path) {
  const recording::MappedFile file(path);
  const std::string name = path.string();
  const std::string_view text = file.text();
  if (text.empty()) throw Error(ExitCode::kBadFile, name, "is empty.");
  if (text.starts_with("\x89PNG")) return describe_png(path);
  if (text.starts_with("\x89"
                       "EFM") ||
      path.extension() == ".efm")
    return describe_model(file.bytes(), name);
  if (text.starts_with("% ")) return describe_raw(file.bytes(), name);
  if (path.extension() == ".toml") return describe_camera(text, name);
  if (path.extension() == ".dbc") return describe_dbc(text, name);
  if (text.starts_with("(")) return describe_candump(file.bytes());
  const int numbers = numbers_in_first_line(text);
  if (numbers == 4) return describe_text_events(text);
  if (numbers == 8) return describe_poses(text, name);
  throw Error(ExitCode::kBadFile, name,
              "is of no known kind. Known: Prophesee RAW, text events (t x y p), candump log, .dbc, poses (t "
              "px py pz qx qy "
              "qz qw), .toml, .png, .efm, and recording folders.");
}

}  // namespace egofocus::app
