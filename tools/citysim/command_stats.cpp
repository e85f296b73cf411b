#include <cstdio>
#include <thread>

#include "citysim/command_line.hpp"
#include "citysim/commands.hpp"
#include "citysim/scene_statistics.hpp"
#include "recording/json.hpp"
#include "recording/number_text.hpp"
#include "recording/progress.hpp"

namespace egofocus::citysim {
namespace {

constexpr const char* kExamples = R"(
Depth bins, in metres, and the sky; textureless: the log light of the 5x5 pixels around varies by less than 0.08;
nearer, farther: outside the parallax ladder of the true motion, where there is parallax; nearer_worst: in the
world with most of it. full_ladder_views: the ladder spans its full parallax. motion_px_s: median image speed.

Examples:
  citysim stats                                all families
  citysim stats town4 town5_night --worlds 8   some, more closely
  citysim stats --json                         one line of JSON for each)";

struct Column {
  const char* title;
  double value;
  int decimals;
};

std::vector<Column> columns_of(const SceneStatistics& s) {
  static constexpr const char* kBins[] = {"<0.5", "<1",  "<2",   "<4",   "<8", "<16",
                                          "<32",  "<80", "<256", "more", "sky"};
  std::vector<Column> out;
  for (std::size_t i = 0; i < s.depth_share.size(); ++i) out.push_back({kBins[i], s.depth_share[i], 3});
  out.push_back({"textureless", s.textureless_share, 3});
  out.push_back({"movers", s.mover_share, 3});
  out.push_back({"nearer", s.nearer_share, 3});
  out.push_back({"nearer_worst", s.worst_nearer_share, 3});
  out.push_back({"farther", s.farther_share, 3});
  out.push_back({"no_parallax_views", s.no_parallax_views, 2});
  out.push_back({"full_ladder_views", s.full_ladder_views, 2});
  out.push_back({"motion_px_s", s.motion_px_s, 0});
  out.push_back({"mean_m_s", s.mean_speed_m_s, 2});
  out.push_back({"top_m_s", s.top_speed_m_s, 2});
  out.push_back({"top_rad_s", s.top_rate_rad_s, 2});
  return out;
}

}  // namespace

int run_stats(std::span<const std::string> arguments) {
  std::vector<std::string> names;
  int worlds = 4;
  int views = 40;
  std::uint64_t seed = 1;
  bool json = false;
  CLI::App program("What the families' scenes are like.", "citysim stats");
  program.footer(about_families() + kExamples);
  program.add_option("families", names, "none: all");
  program.add_option("--worlds", worlds, "scenes of each family")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  program.add_option("--views", views, "looks at each scene, over a minute")
      ->check(CLI::Range(2, 1000))
      ->capture_default_str();
  program.add_option("--seed", seed, "of the first scene; the next ones follow")->capture_default_str();
  program.add_flag("--json", json, "one line of JSON for each family");
  int code = 0;
  if (!parse(program, arguments, code)) return code;

  std::vector<Family> chosen;
  for (const std::string& name : names) chosen.push_back(parse_family(name));
  if (chosen.empty()) {
    for (const FamilyName& family : families()) chosen.push_back(family.family);
  }
  Workers workers(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
  std::vector<SceneStatistics> rows;
  {
    recording::Progress progress("looking around");
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      progress.show(i, chosen.size());
      rows.push_back(scene_statistics(chosen[i], worlds, views, seed, workers));
    }
  }
  if (!json) {
    std::printf("%-18s", "");
    for (const Family family : chosen) std::printf(" %12s", std::string(name_of(family)).c_str());
    std::puts("");
    for (std::size_t line = 0; line < columns_of(rows[0]).size(); ++line) {
      std::printf("%-18s", columns_of(rows[0])[line].title);
      for (const SceneStatistics& row : rows) {
        const Column column = columns_of(row)[line];
        std::printf(" %12s", recording::fixed_text(column.value, column.decimals).c_str());
      }
      std::puts("");
    }
    return 0;
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    recording::Json facts;
    facts.add("family", name_of(chosen[i]))
        .add("worlds", worlds)
        .add("views", rows[i].views)
        .add("seed", seed);
    for (const Column& column : columns_of(rows[i])) facts.add(column.title, column.value);
    std::puts(facts.json().c_str());
  }
  return 0;
}

}  // namespace egofocus::citysim
