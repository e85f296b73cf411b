// The recorder without its thread: what a slow disk costs, what is in the files, when a folder is whole.
#include "recorder.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/evt_decoder.hpp"
#include "hal/raw_header.hpp"
#include "recording/error.hpp"
#include "recording/mapped_file.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using daemon::DaemonConfig;
using daemon::Recorder;

namespace {

constexpr std::int64_t kBegin_us = 5'000'000'000;

// A recorder into a temporary folder, of what the fixture's configuration gives.
struct Bench {
  Bench() : setup(config()) {}

  DaemonConfig config() {
    const std::filesystem::path file = folder / "d.toml";
    recording::write_text_file(
        file, "[source]\nrecording = \"" + test::source_dir() +
                  "/fixtures/planes\"\n[engine]\nbackend = \"focus\"\n[record]\nfolder = \"" +
                  folder.path().string() +
                  "\"\nbuffer_events = 65536\nmax_mib = 1\n[can]\ninterface = \"slcan1\"\n");
    return daemon::read_daemon_config(file);
  }

  // `count` events from number `first` on, one a microsecond.
  static std::vector<Event> events(std::int64_t first, std::int64_t count) {
    std::vector<Event> made;
    for (std::int64_t i = first; i < first + count; ++i)
      made.push_back({kBegin_us + i, static_cast<std::uint16_t>(i % 240), static_cast<std::uint16_t>(i % 180),
                      static_cast<std::uint8_t>(i % 2)});
    return made;
  }

  void begin() {
    recorder.begin(setup, kBegin_us);
    recorder.work();
  }

  TemporaryFolder folder;
  daemon::Setup setup;
  Recorder recorder{setup.daemon.record};
};

std::vector<Event> read_events(const std::filesystem::path& path) {
  const recording::MappedFile file(path);
  RawHeader header;
  REQUIRE(parse_raw_header(file.bytes(), header).ok());
  CHECK(header.size.width_px == 240);
  EvtDecoder decoder(header.format, header.size);
  std::vector<Event> all(1 << 18);
  all.resize(decoder.feed(file.bytes().subspan(header.header_bytes), all).produced);
  return all;
}

}  // namespace

TEST_CASE("nothing is taken before a recording begins and after it ended, and all in between") {
  Bench bench;
  bench.recorder.take(Bench::events(0, 100));
  bench.begin();
  bench.recorder.take(Bench::events(1000, 500));
  CanFrame frame;
  frame.t_us = kBegin_us + 1234;
  frame.id = 0x174;
  frame.length = 2;
  frame.data[1] = 0xab;
  bench.recorder.take(frame);
  bench.recorder.note_health("{}");
  CHECK(bench.recorder.facts().on);
  CHECK_FALSE(std::filesystem::exists(bench.recorder.facts().folder));
  CHECK(bench.recorder.end());
  bench.recorder.work();
  bench.recorder.take(Bench::events(2000, 100));
  bench.recorder.work();
  const daemon::RecorderFacts facts = bench.recorder.facts();
  CHECK_FALSE(facts.on);
  CHECK(facts.failure.empty());
  CHECK(facts.events_dropped == 0);
  const std::vector<Event> got = read_events(std::filesystem::path(facts.folder) / "events.raw");
  REQUIRE(got.size() == 500);
  CHECK(got.front().t_us == 1000);
  CHECK(got.back().t_us == 1499);
  CHECK(got.back().x == 1499 % 240);
  CHECK(recording::read_text_file(facts.folder + "/can.log") == "(0000000000.001234) slcan1 174#00AB\n");
  CHECK(recording::read_text_file(facts.folder + "/health.jsonl") == "{}\n");
  CHECK(recording::read_text_file(facts.folder + "/vehicle.dbc") ==
        recording::read_text_file(test::source_dir() + "/fixtures/planes/vehicle.dbc"));
  CHECK_FALSE(bench.recorder.end());
}

TEST_CASE("a disk that is too slow costs events beyond the buffer, each counted, and none before") {
  Bench bench;
  bench.begin();
  bench.recorder.take(Bench::events(0, 70'000));
  CHECK(bench.recorder.facts().events_dropped == 70'000 - 65'536);
  bench.recorder.work();
  bench.recorder.take(Bench::events(70'000, 10));
  bench.recorder.end();
  bench.recorder.work();
  const daemon::RecorderFacts facts = bench.recorder.facts();
  const std::vector<Event> got = read_events(std::filesystem::path(facts.folder) / "events.raw");
  REQUIRE(got.size() == 65'546);
  CHECK(got[65'535].t_us == 65'535);
  CHECK(got[65'536].t_us == 70'000);
}

TEST_CASE("a recording ends whole at its largest size, and the next one has a name of its own") {
  Bench bench;
  bench.begin();
  for (std::int64_t i = 0; bench.recorder.facts().on && i < 100; ++i) {
    bench.recorder.take(Bench::events(i * 60'000, 60'000));
    bench.recorder.work();
  }
  const daemon::RecorderFacts first = bench.recorder.facts();
  CHECK_FALSE(first.on);
  CHECK(first.bytes > 1 << 20);
  CHECK(first.bytes < 2 << 20);
  CHECK(std::filesystem::exists(first.folder));
  bench.begin();
  CHECK_THROWS_AS(bench.recorder.begin(bench.setup, kBegin_us), recording::Error);
  bench.recorder.end();
  bench.recorder.work();
  CHECK(bench.recorder.facts().folder != first.folder);
  CHECK(std::filesystem::exists(bench.recorder.facts().folder));
}

TEST_CASE("a folder that cannot be written ends the recording with a reason") {
  Bench bench;
  std::filesystem::remove_all(bench.folder.path());
  bench.begin();
  const daemon::RecorderFacts facts = bench.recorder.facts();
  CHECK_FALSE(facts.on);
  CHECK(facts.failure.find("cannot be made (No such file or directory)") != std::string::npos);
}
