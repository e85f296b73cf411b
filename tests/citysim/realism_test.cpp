// Drawn sensors over a scrolling texture beside a real sensor on a slider: the real one must look like one of
// them. The recording is read in place; where it is not there, the test says so.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "citysim/dvs.hpp"
#include "citysim/event_statistics.hpp"
#include "citysim/event_stream.hpp"
#include "citysim/realism.hpp"
#include "recording/error.hpp"
#include "recording/raw_file.hpp"
#include "recording/temporary_folder.hpp"
#include "scrolling_texture.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::citysim;

namespace {

// About the slider's 29 to 106 px/s.
std::vector<Event> simulated(std::uint64_t seed, int width_px, int height_px) {
  ScrollingTexture::Look look;
  look.illumination = 0.7;
  const ScrollingTexture texture(width_px, height_px, look, seed);
  Dvs dvs(width_px, height_px, draw_dvs_parameters(seed, false), seed);
  Workers workers(1);
  std::vector<Event> events;
  for (std::int64_t t_us = 0; t_us <= 270'000; t_us += 4500) {
    const std::vector<float> view = texture.picture(static_cast<double>(t_us) * 1e-6);
    const LightView shown{t_us, view};
    dvs.show({&shown, 1}, workers, events);
  }
  dvs.finish(events);
  // The first ones come of references that are all new.
  std::erase_if(events, [](const Event& event) { return event.t_us < 100'000; });
  return events;
}

struct Named {
  const char* name;
  double EventStatistics::*member;
};
// All that the motion alone does not decide.
constexpr Named kCompared[] = {{"pixel_rate_hz", &EventStatistics::pixel_rate_hz},
                               {"active_share", &EventStatistics::active_share},
                               {"on_share", &EventStatistics::on_share},
                               {"flip_share", &EventStatistics::flip_share},
                               {"median_interval_us", &EventStatistics::median_interval_us},
                               {"burst_events", &EventStatistics::burst_events},
                               {"median_burst_us", &EventStatistics::median_burst_us},
                               {"median_gap_us", &EventStatistics::median_gap_us},
                               {"isolated_share", &EventStatistics::isolated_share},
                               {"unannounced_share", &EventStatistics::unannounced_share},
                               {"neighbours", &EventStatistics::neighbours},
                               {"hot_event_share", &EventStatistics::hot_event_share}};

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

int exit_code_of(const std::vector<std::string>& arguments) {
  try {
    return run_realism(arguments);
  } catch (const recording::Error& error) {
    REQUIRE(std::string(error.what()).find(arguments[0]) != std::string::npos);
    return error.exit_code();
  }
}

}  // namespace

TEST_CASE("a real sensor's statistics lie within those of the drawn ones") {
  const char* given = std::getenv("EGOFOCUS_REAL_DATA");
  const std::filesystem::path real =
      std::filesystem::path(given ? given : test::source_dir() + "/../shared/real") / "slider_depth" /
      "events_chunk.txt";
  if (!std::filesystem::exists(real)) {
    WARN("skipped: no " << real.string() << " (set EGOFOCUS_REAL_DATA to the folder that has slider_depth/)");
    return;
  }
  const EventStream slider = read_event_stream(real);
  REQUIRE(slider.size.width_px == 240);
  REQUIRE(slider.events.size() == 50'000);
  const EventStatistics truth = event_statistics(slider.events, 240, 180);

  std::vector<EventStatistics> drawn;
  for (std::uint64_t seed = 1; seed <= 16; ++seed)
    drawn.push_back(event_statistics(simulated(seed, 240, 180), 240, 180));
  for (const Named& compared : kCompared) {
    std::vector<double> values;
    for (const EventStatistics& s : drawn) values.push_back(s.*compared.member);
    std::sort(values.begin(), values.end());
    std::printf("%-20s real %9.3f, drawn %9.3f to %9.3f, median %9.3f\n", compared.name,
                truth.*compared.member, values.front(), values.back(), values[values.size() / 2]);
    INFO(compared.name);
    CHECK(truth.*compared.member >= values.front());
    CHECK(truth.*compared.member <= values.back());
  }
}

TEST_CASE("streams are read whole from a folder, RAW and text, and bad ones are refused") {
  const TemporaryFolder folder;
  std::vector<Event> events(3);
  events[1].t_us = 2000;
  events[2].t_us = 2500;
  events[2].x = 239;
  events[2].y = 5;
  events[2].polarity = 1;
  recording::write_raw_file(folder / "events.raw", events, {320, 240});
  write(folder / "events.txt", "0.000000 0 0 0\n0.002 0 0 0\n0.0025 239 5 1\n0.001 7 7 1\nnonsense\n");
  const EventStream whole = read_event_stream(folder / "");
  REQUIRE(whole.size.width_px == 320);
  REQUIRE(whole.dropped == 0);
  const EventStream text = read_event_stream(folder / "events.txt");
  REQUIRE(text.size.width_px == 240);
  REQUIRE(text.dropped == 2);
  for (const EventStream* stream : {&whole, &text}) {
    REQUIRE(stream->events.size() == 3);
    REQUIRE(stream->events[2].t_us == 2500);
    REQUIRE(stream->events[2].x == 239);
    REQUIRE(stream->events[2].polarity == 1);
  }

  const std::string raw = (folder / "events.raw").string();
  REQUIRE(exit_code_of({raw, raw, "--seconds", "0.001"}) == 0);
  REQUIRE(exit_code_of({raw, "--json"}) == 0);
  REQUIRE(exit_code_of({raw, "--no-such"}) == 2);
  REQUIRE(exit_code_of({raw, "--seconds", "-1"}) == 2);
  REQUIRE(exit_code_of({(folder / "missing.raw").string()}) == 3);
  write(folder / "wide.txt", "0.1 60000 60000 1\n");
  write(folder / "wide.raw", "% evt 3.0\n% geometry 60000x60000\n% end\n");
  write(folder / "words.txt", "these are\nno events\n");
  for (const char* name : {"wide.txt", "wide.raw", "words.txt"})
    REQUIRE(exit_code_of({(folder / name).string()}) == 4);
  recording::write_raw_file(folder / "empty.raw", {}, {320, 240});
  REQUIRE(exit_code_of({(folder / "empty.raw").string()}) == 7);
}
