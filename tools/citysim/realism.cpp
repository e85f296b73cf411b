#include "citysim/realism.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <vector>

#include "citysim/event_statistics.hpp"
#include "citysim/event_stream.hpp"
#include "recording/error.hpp"
#include "recording/number_text.hpp"

namespace egofocus::citysim {
namespace {

using recording::fixed_text;

struct Row {
  std::string name;   ///< a key of the JSON
  std::string value;  ///< a number
};

std::string bin_name(std::size_t bin) {
  if (bin == 0) return "interval_below_" + std::to_string(kIntervalBounds_us[0]) + "us";
  return "interval_from_" + std::to_string(kIntervalBounds_us[bin - 1]) + "us";
}

std::vector<Row> rows_of(const EventStream& stream, const EventStatistics& s) {
  std::vector<Row> rows = {
      {"width_px", std::to_string(stream.size.width_px)},
      {"height_px", std::to_string(stream.size.height_px)},
      {"events", std::to_string(s.events)},
      {"dropped", std::to_string(stream.dropped)},
      {"duration_s", fixed_text(static_cast<double>(s.duration_us) * 1e-6, 3)},
      {"pixel_rate_hz", fixed_text(s.pixel_rate_hz, 2)},
      {"active_share", fixed_text(s.active_share, 3)},
      {"on_share", fixed_text(s.on_share, 3)},
      {"peak_to_mean", fixed_text(s.peak_to_mean, 2)},
      {"flip_share", fixed_text(s.flip_share, 3)},
      {"median_interval_ms", fixed_text(s.median_interval_us * 1e-3, 2)},
      {"burst_events", fixed_text(s.burst_events, 2)},
      {"bursts_of_1", fixed_text(s.burst_share[0], 3)},
      {"bursts_of_2", fixed_text(s.burst_share[1], 3)},
      {"bursts_of_3", fixed_text(s.burst_share[2], 3)},
      {"bursts_of_4_or_more", fixed_text(s.burst_share[3], 3)},
      {"median_burst_ms", fixed_text(s.median_burst_us * 1e-3, 2)},
      {"median_gap_ms", fixed_text(s.median_gap_us * 1e-3, 2)},
      {"isolated_share", fixed_text(s.isolated_share, 4)},
      {"unannounced_share", fixed_text(s.unannounced_share, 4)},
      {"neighbours", fixed_text(s.neighbours, 2)},
      {"hot_pixel_share", fixed_text(s.hot_pixel_share, 5)},
      {"hot_event_share", fixed_text(s.hot_event_share, 4)},
  };
  for (std::size_t i = 0; i < s.interval_share.size(); ++i)
    rows.push_back({bin_name(i), fixed_text(s.interval_share[i], 3)});
  return rows;
}

std::string json_name(const std::string& name) {
  std::string text;
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    text += static_cast<unsigned char>(c) < 0x20 ? '?' : c;
  }
  return text;
}

void print_json(const std::string& name, const std::vector<Row>& rows) {
  std::string line = "{\"recording\": \"" + json_name(name) + "\"";
  for (const Row& row : rows) line += ", \"" + row.name + "\": " + row.value;
  std::puts((line + "}").c_str());
}

void print_table(const std::vector<std::string>& names, const std::vector<std::vector<Row>>& columns) {
  constexpr std::size_t kNameWidth = 26;
  const auto padded = [](const std::string& text, std::size_t width) {
    return std::string(width - std::min(width, text.size()), ' ') + text;
  };
  std::string line(kNameWidth, ' ');
  for (const std::string& name : names) line += padded(name, std::max<std::size_t>(12, name.size() + 2));
  std::puts(line.c_str());
  for (std::size_t row = 0; row < columns[0].size(); ++row) {
    line = columns[0][row].name;
    line.resize(kNameWidth, ' ');
    for (std::size_t i = 0; i < columns.size(); ++i)
      line += padded(columns[i][row].value, std::max<std::size_t>(12, names[i].size() + 2));
    std::puts(line.c_str());
  }
}

}  // namespace

int run_realism(std::span<const std::string> arguments) {
  using recording::Error;
  using recording::ExitCode;
  CLI::App command("Statistics of event streams, side by side.", "citysim realism");
  std::vector<std::string> paths;
  double seconds = 0;
  bool json = false;
  command.add_option("RECORDING", paths, "folder with events.raw, RAW file, or text events (t x y p)")
      ->required();
  command.add_option("--seconds", seconds, "of each, only the first S seconds; 0: all of it")
      ->check(CLI::Range(0.0, 1e6));
  command.add_flag("--json", json, "a line of JSON for each instead of a table");
  command.footer("Example:\n  citysim realism fixtures/planes --seconds 0.2");
  try {
    command.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::ParseError& error) {
    return static_cast<int>(command.exit(error) == 0 ? ExitCode::kOk : ExitCode::kUsage);
  }

  std::vector<std::string> names;
  std::vector<std::vector<Row>> columns;
  for (const std::string& path : paths) {
    EventStream stream = read_event_stream(path);
    if (stream.events.empty()) throw Error(ExitCode::kNoEvents, path, "holds no events.");
    if (seconds > 0) {
      const std::int64_t end_us = stream.events.front().t_us + static_cast<std::int64_t>(seconds * 1e6);
      stream.events.erase(std::find_if(stream.events.begin(), stream.events.end(),
                                       [&](const Event& event) { return event.t_us > end_us; }),
                          stream.events.end());
    }
    columns.push_back(
        rows_of(stream, event_statistics(stream.events, stream.size.width_px, stream.size.height_px)));
    const std::filesystem::path last(path);
    names.push_back(last.has_filename() ? last.filename().string() : last.parent_path().filename().string());
    if (json) print_json(names.back(), columns.back());
  }
  if (!json) print_table(names, columns);
  return static_cast<int>(ExitCode::kOk);
}

}  // namespace egofocus::citysim
