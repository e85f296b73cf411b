#include "recording/convert_ecd.hpp"

#include <catch2/catch.hpp>
#include <cstdlib>

#include "hal/evt_decoder.hpp"
#include "recording/error.hpp"
#include "recording/folder.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_events.hpp"
#include "recording/text_file.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using Catch::Matchers::Contains;

namespace {

const std::string kEvents =
    "0.000100 10 20 1\n0.000200 11 21 0\n# comment\n\n0.000150 12 22 1\n0.0003009 239 179 1\r\nnonsense\n"
    "0.000400 240 5 1\n0.000500 1 2 3\n0.000600 70000 2 1\n0.9 7 8 0\n";
const std::string kPoses = "0.0002 0 0 0 0 0 0 1\n0.05 1 0 0 0 0 0 1\n";

struct TextSet : TemporaryFolder {
  TextSet() {
    put("events.txt", kEvents);
    put("calib.txt", "199.5 200 120 90 -0.1 0.02 0 0 0.0\n");
    put("groundtruth.txt", kPoses);
  }
  void put(const std::string& name, const std::string& text) const { write_text_file(*this / name, text); }

  [[nodiscard]] std::string complaint(ExitCode code, const ConvertOptions& options = {}) const {
    try {
      (void)convert_ecd(path(), *this / "out", options);
    } catch (const Error& error) {
      CHECK(error.exit_code() == static_cast<int>(code));
      return error.what();
    }
    return "no complaint";
  }
};

std::vector<Event> decode(const MappedFile& file) {
  RawHeader header;
  REQUIRE(parse_raw_header(file.bytes(), header).ok());
  EvtDecoder decoder(header.format, header.size);
  std::vector<Event> events(100000);
  const Decoded step = decoder.feed(file.bytes().subspan(header.header_bytes), events);
  events.resize(step.produced);
  return events;
}

}  // namespace

TEST_CASE("a text line is an event or is counted") {
  const TextEvents text = parse_text_events(kEvents);
  CHECK(text.lines == 11);
  CHECK(text.blank == 2);
  CHECK(text.malformed == 3);
  CHECK(text.out_of_order == 1);
  REQUIRE(text.events.size() == 5);
  CHECK(text.events[2].t_us == 301);  // 300.9 us, to the nearest
  CHECK(text.events[2].x == 239);
  CHECK(text.events[1].polarity == 0);
  CHECK(parse_text_events("5 1 1 -1").events.at(0).polarity == 0);
  CHECK(parse_text_events("").lines == 0);
}

TEST_CASE("a text set becomes a recording, and what was dropped is counted") {
  TextSet set;
  set.put("imu.txt", "");
  ConvertOptions options;
  options.size = SensorSize{240, 180};
  const ConvertReport report = convert_ecd(set.path(), set / "out", options);
  CHECK(report.events == 4);
  CHECK(report.out_of_range == 1);
  CHECK(report.out_of_order == 1);
  CHECK(report.malformed == 3);
  CHECK(report.before_t0 == 0);
  CHECK(report.events_before_poses == 1);
  CHECK(report.events_after_poses == 1);
  CHECK(report.left_out == std::vector<std::string>{"imu.txt"});

  const Folder folder = open_folder(set / "out");
  CHECK(folder.camera.config.camera.distortion == Distortion::kPlumbBob);
  CHECK(folder.camera.config.camera.intrinsics.fx_px == 199.5);
  CHECK(folder.camera.config.motion.source == MotionSource::kPoses);
  CHECK(folder.poses.size() == 2);
  const std::vector<Event> events = decode(folder.events);
  REQUIRE(events.size() == 4);
  CHECK(events[0].t_us == 100);
  CHECK(events[2].x == 239);
  CHECK(events[2].y == 179);
  CHECK(events[3].t_us == 900000);
  CHECK_THAT(set.complaint(ExitCode::kUsage), Contains("already holds a recording"));
}

TEST_CASE("the sensor is guessed from calibration and events") {
  TextSet set;
  CHECK(convert_ecd(set.path(), set / "out", {}).size.width_px == 320);  // one event lies at x = 240
  set.put("calib.txt", "199.5 200 1200 90");
  std::filesystem::remove_all(set / "out");
  CHECK_THAT(set.complaint(ExitCode::kConfiguration),
             Contains("fit no known sensor (events reach 241x180)") && Contains("--size"));
}

TEST_CASE("times since an epoch are moved to a small origin") {
  TextSet set;
  set.put("events.txt", "1436509052.25 1 2 1\n1436509053.5 2 2 0\n");
  set.put("groundtruth.txt", "1436509052.2 0 0 0 0 0 0 1\n1436509052.25 0 0 0 0 0 0 1\n");
  const ConvertReport report = convert_ecd(set.path(), set / "out", {});
  CHECK(report.t0_us == 1436509052000000);
  CHECK(report.first_us == 250000);
  CHECK(open_folder(set / "out").poses[0].t_us == 200000);

  std::filesystem::remove_all(set / "out");
  ConvertOptions later;
  later.t0_us = 1436509053000000;
  CHECK(convert_ecd(set.path(), set / "out", later).before_t0 == 1);
}

TEST_CASE("a text set that cannot be converted says why") {
  const auto without = [](const char* name, ExitCode code) {
    TextSet set;
    std::filesystem::remove(set / name);
    return set.complaint(code);
  };
  CHECK_THAT(without("events.txt", ExitCode::kFile), Contains("neither events.txt nor events_chunk.txt"));
  CHECK_THAT(without("calib.txt", ExitCode::kFile), Contains("calib.txt"));
  CHECK_THAT(without("groundtruth.txt", ExitCode::kMotion), Contains("no motion"));
  TextSet set;
  set.put("calib.txt", "199 200 120\n");
  CHECK_THAT(set.complaint(ExitCode::kBadFile), Contains("ends before the fourth"));
  set.put("calib.txt", "199 200 120 ninety\n");
  CHECK_THAT(set.complaint(ExitCode::kBadFile), Contains("must hold the numbers"));
  set.put("calib.txt", "199.5 200 120 90\n");
  set.put("events.txt", "a b c d\n");
  CHECK_THAT(set.complaint(ExitCode::kNoEvents), Contains("1 malformed lines"));
  set.put("events.txt", "5.0 1 1 1\n");
  ConvertOptions late;
  late.t0_us = 6000000;
  CHECK_THAT(set.complaint(ExitCode::kNoEvents, late), Contains("--t0"));
  ConvertOptions wrong;
  wrong.size = SensorSize{1280, 720};
  CHECK_THAT(set.complaint(ExitCode::kConfiguration, wrong), Contains("near the middle"));
}

TEST_CASE("the real slider converts without loss") {
  const char* given = std::getenv("EGOFOCUS_REAL_DATA");
  const std::filesystem::path real = given ? given : egofocus::test::source_dir() + "/../shared/real";
  if (!std::filesystem::exists(real / "slider_depth")) {
    WARN("no real recordings at " << real.string() << " (set EGOFOCUS_REAL_DATA): not exercised");
    return;
  }
  const TemporaryFolder folder;
  const ConvertReport report = convert_ecd(real / "slider_depth", folder / "out", {});
  CHECK(report.size.width_px == 240);
  CHECK(report.events == 50000);
  CHECK(report.malformed + report.out_of_order + report.out_of_range + report.before_t0 == 0);
  CHECK(report.first_us == 3811);
  CHECK(report.last_us == 174156);
  CHECK(report.poses == 339);
  CHECK(report.t0_us == 0);
  const std::vector<Event> events = decode(open_folder(folder / "out").events);
  REQUIRE(events.size() == 50000);
  CHECK(events.front().x == 96);
  CHECK(events.front().y == 133);
}
