// The configuration file: its commented default, every wrong key by its line, and all of them at once.
#include "daemon_config.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "tick_watch.hpp"

using namespace egofocus;
using namespace egofocus::daemon;

namespace {

std::vector<std::string> problems_of(const std::string& text) {
  DaemonConfig config;
  return parse_daemon_config(text, "d.toml", config);
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

const std::string kDefault = default_config_text();
std::string sound() {
  return with(kDefault, "# recording =", "recording =");
}

int line_of(const std::string& text, const std::string& part) {
  return 1 +
         static_cast<int>(std::count(text.begin(), text.begin() + static_cast<long>(text.find(part)), '\n'));
}

}  // namespace

TEST_CASE("the commented default lacks the recording alone, and says what the program does without it") {
  const auto problems = problems_of(kDefault);
  REQUIRE(problems.size() == 1);
  CHECK(problems[0].find("[source] `recording` is missing") != std::string::npos);
  DaemonConfig from_text;
  CHECK(parse_daemon_config(sound(), "/etc/x/d.toml", from_text).empty());
  CHECK(from_text.source.recording == "/etc/x/recording");
  const DaemonConfig built_in;
  CHECK(from_text.source.clock == built_in.source.clock);
  CHECK(from_text.source.first_tick_us == built_in.source.first_tick_us);
  CHECK(from_text.source.at_end == built_in.source.at_end);
  CHECK(from_text.source.wait_for_reader == built_in.source.wait_for_reader);
  CHECK(std::string(from_text.can.interface_name) == built_in.can.interface_name);
  CHECK(from_text.can.hardware_time == built_in.can.hardware_time);
  CHECK(from_text.can.wait_for_interface == built_in.can.wait_for_interface);
  CHECK(from_text.can.restart_after_us == built_in.can.restart_after_us);
  CHECK(from_text.can.receive_buffer_bytes == built_in.can.receive_buffer_bytes);
  CHECK(from_text.engine.backend == built_in.engine.backend);
  CHECK(from_text.engine.threads == built_in.engine.threads);
  CHECK(from_text.engine.rate_hz == built_in.engine.rate_hz);
  CHECK(from_text.engine.lateness_us == built_in.engine.lateness_us);
  CHECK(from_text.engine.max_late_us == built_in.engine.max_late_us);
  CHECK(from_text.engine.max_event_rate_hz == built_in.engine.max_event_rate_hz);
  CHECK(from_text.engine.real_time.fifo_priority == built_in.engine.real_time.fifo_priority);
  CHECK(from_text.engine.real_time.cpu == built_in.engine.real_time.cpu);
  CHECK(from_text.engine.real_time.lock_memory == built_in.engine.real_time.lock_memory);
  CHECK(from_text.depth.socket == built_in.depth.socket);
  CHECK(from_text.depth.group == built_in.depth.group);
  CHECK(from_text.depth.slots == built_in.depth.slots);
  CHECK(from_text.control.socket == built_in.control.socket);
  CHECK(from_text.metrics.file == built_in.metrics.file);
  CHECK(from_text.record.folder == built_in.record.folder);
  CHECK(from_text.record.buffer_events == built_in.record.buffer_events);
  CHECK(from_text.record.max_mib == built_in.record.max_mib);
}

TEST_CASE("each key that the program knows stands in the default") {
  for (const std::string section : {"source", "can", "engine", "depth", "control", "metrics", "record"}) {
    const auto problems =
        problems_of("[source]\nrecording = \"r\"\n" +
                    (section == "source" ? std::string() : "[" + section + "]\n") + "no_such_key = 1\n");
    REQUIRE(problems.size() == 1);
    const std::size_t begin = problems[0].find("Known keys: ") + 12;
    std::string list = problems[0].substr(begin, problems[0].size() - begin - 1) + ",";
    const std::string text = kDefault.substr(kDefault.find("\n[" + section + "]"));
    for (std::size_t end = list.find(','); end != std::string::npos; end = list.find(',')) {
      const std::string key = list.substr(0, end);
      INFO(section << ": " << key);
      const std::size_t next_section = text.find("\n[", 1);
      const std::size_t at = std::min(text.find("\n" + key + " = "), text.find("\n# " + key + " = "));
      CHECK(at < next_section);
      list.erase(0, std::min(list.size(), end + 2));
    }
  }
}

TEST_CASE("what is wrong or contradicts itself is named with its line") {
  struct Case {
    const char* from;
    const char* to;
    const char* says;
  };
  const Case cases[] = {
      {"threads = 1 ", "thraeds = 1 ", "[engine] has no key `thraeds`"},
      {"[metrics]", "[metrcs]", "unknown section or key `metrcs`"},
      {"slots = 4", "slots = 5", "[depth] `slots` must be a power of two"},
      {"slots = 4", "slots = \"4\"", "[depth] `slots` must be an integer"},
      {"backend = \"network\"", "backend = \"neural\"",
       "[engine] `backend` must be one of \"network\", \"focus\""},
      {"events = \"replay\"", "events = \"usb9\"", "[source] `events` must be one of"},
      {"clock = \"real\"", "clock = \"virtual\"\nat_end = \"repeat\" #", "already defined"},
      {"at_end = \"stop\"", "at_end = \"repeat\" # ", ""},
      {"wait_for_reader = false", "wait_for_reader = true",
       "[source] `wait_for_reader` is for clock = \"virtual\" and"},
      {"clock = \"real\"", "clock = \"device\"", "[source] `clock` cannot be \"device\" with"},
      {"first_tick_us = 0", "first_tick_us = 5", "[source] `first_tick_us` is for clock = \"device\" alone"},
      {"# model = ", "backend2 = 0\nmodel = ", "[engine] has no key `backend2`"},
      {"buffer_events = 1048576", "buffer_events = 1000", "[record] `buffer_events` must be a power of two"},
      {"max_mib = 4096", "max_mib = 0", "[record] `max_mib` must lie in"},
      {"interface = \"can0\"", "interface = \"a_name_too_long_\"",
       "[can] `interface` must have 1..15 characters"},
      {"interface = \"can0\"", "interface = \"can 0\"", "[can] `interface` must have 1..15 characters"},
      {"restart_after_us = 0", "restart_after_us = -1", "[can] `restart_after_us` must not be negative"},
      {"group = true", "group = 1", "[depth] `group` must be true or false"},
  };
  for (const Case& c : cases) {
    INFO(c.to);
    const std::string text = with(sound(), c.from, c.to);
    const auto problems = problems_of(text);
    if (*c.says == '\0') {
      CHECK(problems.empty());
      continue;
    }
    REQUIRE_FALSE(problems.empty());
    INFO(problems[0]);
    if (std::string(c.says) == "already defined") continue;  // toml++'s own words
    CHECK(problems[0].find(c.says) != std::string::npos);
    const std::string first_line = std::string(c.to).substr(0, std::string(c.to).find('\n'));
    CHECK(problems[0].rfind("d.toml:" + std::to_string(line_of(text, first_line)) + ":", 0) == 0);
  }
  CHECK(problems_of(with(with(sound(), "clock = \"real\"", "clock = \"virtual\""), "at_end = \"stop\"",
                         "at_end = \"repeat\""))
            .size() == 1);
  CHECK(
      problems_of(with(with(sound(), "backend = \"network\"", "backend = \"focus\""), "# model =", "model ="))
          .size() == 1);
  CHECK(problems_of(with(sound(), "control.sock", "depth.sock")).size() == 1);
  CHECK(problems_of(with(sound(), "# camera =", "camera =")).size() == 1);
  CHECK(problems_of("[source\n").size() == 1);
  CHECK(problems_of("").size() == 1);
}

TEST_CASE("devices are both live, have a camera file, no recording and no virtual clock") {
  const std::string live = "[source]\nevents = \"usb\"\nmotion = \"can\"\n";
  const std::string engine = "[engine]\ncamera = \"robot.toml\"\n";
  DaemonConfig config;
  CHECK(parse_daemon_config(live + engine, "/etc/x/d.toml", config).empty());
  CHECK(config.source.events == EventsFrom::kUsb);
  CHECK(config.engine.camera == "/etc/x/robot.toml");
  CHECK(problems_of(with(live, "usb", "v4l2") + engine).empty());
  CHECK(problems_of(live + "clock = \"device\"\nfirst_tick_us = 1000\nwait_for_reader = true\n" + engine)
            .empty());
  const auto only = [](const std::string& text) {
    const auto problems = problems_of(text);
    REQUIRE(problems.size() == 1);
    return problems[0];
  };
  CHECK_THAT(only(live), Catch::Contains("[engine] lacks `camera`"));
  CHECK_THAT(only(with(live, "can", "replay") + engine), Catch::Contains("d.toml:3: [source] `motion`"));
  CHECK_THAT(only(live + "recording = \"r\"\n" + engine), Catch::Contains("d.toml:4: [source] `recording`"));
  CHECK_THAT(only(live + "clock = \"virtual\"\n" + engine), Catch::Contains("d.toml:4: [source] `clock`"));
}

TEST_CASE("all that is wrong is found at once") {
  const auto problems =
      problems_of("[source]\nnothing = 1\n[engine]\nthreads = \"two\"\n[depth]\nslots = 3\n[other]\n");
  CHECK(problems.size() == 4);
}

TEST_CASE("ticks that stop coming are noticed after three periods, never before two seconds") {
  TickWatch watch;
  watch.begin(50'000, 1'000'000);
  CHECK(watch.is_alive(0, 3'000'000));
  CHECK_FALSE(watch.is_alive(0, 3'000'001));
  CHECK(watch.is_alive(1, 9'000'000));
  CHECK(watch.is_alive(1, 11'000'000));
  CHECK_FALSE(watch.is_alive(1, 11'000'001));
  watch.begin(10'000'000, 20'000'000);
  CHECK(watch.is_alive(1, 50'000'000));
  CHECK_FALSE(watch.is_alive(1, 50'000'001));
}
