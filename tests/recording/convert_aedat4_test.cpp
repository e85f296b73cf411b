// AEDAT 4.0 files written by the tests, and a real one read in place.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "recording/aedat4_reader.hpp"
#include "recording/aedat4_writer.hpp"
#include "recording/converted.hpp"
#include "recording/temporary_folder.hpp"
#include "recording/text_file.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;
using namespace egofocus::recording;
using namespace egofocus::test;
using Catch::Matchers::Contains;

namespace {

constexpr std::int64_t kEpochUs = 1'605'537'493'000'000;

const std::string kCamchain =
    "cam0:\n  camera_model: pinhole\n  intrinsics: [300.0, 301.0, 158.0, 121.0]\n  distortion_model: radtan\n"
    "  distortion_coeffs: [-0.3, 0.1, 0.001, -0.002]\n  resolution: [320, 240]\n"
    "  T_cam_imu: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.01], [0, 0, 0, 1]]\n";

struct Aedat4Set : TemporaryFolder {
  std::vector<Event> events = some_events(5000, 320, 240, kEpochUs + 300000);
  std::filesystem::path input = *this / "desk.aedat4";

  Aedat4Set() { write_text_file(*this / "camchain.yaml", kCamchain); }

  [[nodiscard]] std::string written(int compression, bool closed = true) const {
    Aedat4Writer writer(compression, 320, 240);
    // IMU before the first event, an empty packet, a stream of another kind.
    writer.packet(1, imu_packet({{kEpochUs + 250000, {0, 0, -1}, {90, 0, 0}},
                                 {kEpochUs + 300500, {0.5f, 0, -1}, {0, 0, -45}}}));
    writer.packet(0, events_packet({events.begin(), events.begin() + 3000}));
    writer.packet(0, events_packet({}));
    writer.packet(2, packet_root("TRIG", 0).data);
    writer.packet(0, events_packet({events.begin() + 3000, events.end()}));
    return writer.file(closed);
  }

  ConvertReport convert_text(const std::string& bytes) const {
    write_text_file(input, bytes);
    return convert(InputFormat::kAedat4, input, *this / "out", options());
  }
  [[nodiscard]] ConvertOptions options() const {
    ConvertOptions chosen;
    chosen.kalibr = *this / "camchain.yaml";
    return chosen;
  }
  [[nodiscard]] std::string refuse(ExitCode code, const std::string& bytes) const {
    write_text_file(input, bytes);
    return complaint(code, InputFormat::kAedat4, input, *this / "out", options());
  }
};

}  // namespace

TEST_CASE("AEDAT4: every compression gives the events and the IMU that were written") {
  const int compression = GENERATE(0, 1, 2, 3, 4);
  const Aedat4Set set;
  const ConvertReport report = set.convert_text(set.written(compression));
  CHECK(guess_format(set.input) == InputFormat::kAedat4);
  CHECK(report.events == 5000);
  CHECK(report.size.width_px == 320);
  CHECK(report.t0_us == kEpochUs);
  CHECK(report.imu_samples == 2);
  CHECK(report.left_out == std::vector<std::string>{"TRIG"});
  REQUIRE(report.remarks.size() == 1);
  CHECK_THAT(report.remarks[0], Contains("an IMU without velocity"));

  const Folder folder = open_folder(set / "out");
  std::vector<Event> wanted = set.events;
  for (Event& event : wanted) event.t_us -= kEpochUs;
  check_same_events(events_of(folder), wanted);
  CHECK(folder.camera.config.camera.intrinsics.fy_px == 301.0);
  CHECK(folder.camera.config.camera.distortion == Distortion::kPlumbBob);
  CHECK(folder.camera.config.motion.camera_in_body_m[2] == -0.01);
  const std::vector<ImuSample> samples = imu_of(folder);
  REQUIRE(samples.size() == 4);
  CHECK(samples[0].t_us == 250000);
  CHECK(samples[0].gyro_rad_s[0] == Approx(std::numbers::pi / 2));
  CHECK(samples[1].accel_m_s2[2] == Approx(-9.80665));
  CHECK(samples[2].gyro_rad_s[2] == Approx(-std::numbers::pi / 4));
  CHECK(samples[3].accel_m_s2[0] == Approx(0.5 * 9.80665));
}

TEST_CASE("AEDAT4: a file that the recorder never closed is read as far as it goes") {
  const Aedat4Set set;
  const std::string whole = set.written(1, false);
  CHECK(set.convert_text(whole).events == 5000);
  std::filesystem::remove_all(set / "out");
  const ConvertReport cut = set.convert_text(whole.substr(0, whole.size() - 100));
  CHECK(cut.events == 3000);
  REQUIRE(cut.remarks.size() == 2);
  CHECK_THAT(cut.remarks[0], Contains("did not close the file") && Contains(" bytes of a last packet"));
}

TEST_CASE("AEDAT4: no prefix of a closed file is taken for a whole one") {
  const Aedat4Set set;
  const std::string whole = set.written(3);
  const std::size_t table = whole.size() - std::string("the table").size();
  const std::size_t packets = whole.find("</dv>\n") + 6;
  for (std::size_t size = 0; size < table; size += 1 + size / 40) {
    const std::string message = set.refuse(ExitCode::kBadFile, whole.substr(0, size));
    if (size >= packets) {
      CHECK_THAT(message,
                 Contains(std::to_string(size) + " bytes, but its packets end at " + std::to_string(table)));
    } else {
      CHECK_THAT(message, Contains("within its header") || Contains("is empty") || Contains("is no AEDAT"));
    }
  }
}

TEST_CASE("AEDAT4: what is wrong with a file is said") {
  const Aedat4Set set;
  CHECK_THAT(set.refuse(ExitCode::kBadFile, "#!AER-DAT2.0\r\n"), Contains("is no AEDAT 4.0 file"));
  CHECK_THAT(set.refuse(ExitCode::kBadFile, set.written(7)), Contains("names compression 7"));
  std::string broken = set.written(0);
  const std::size_t at = broken.find("EVTS", broken.find("</dv>"));
  broken.replace(at + 20, 4, "\xff\xff\xff\x7f");  // the vector's count
  CHECK_THAT(set.refuse(ExitCode::kBadFile, broken),
             Contains("byte ") && Contains("packet of events is damaged"));
  std::string damaged = set.written(1);
  damaged[damaged.find("</dv>") + 14] = '\x55';  // in the frame's magic
  CHECK_THAT(set.refuse(ExitCode::kBadFile, damaged), Contains("LZ4:"));
  CHECK_THAT(set.refuse(ExitCode::kNoEvents, Aedat4Writer(0, 320, 240).file()), Contains("has no event"));
  CHECK_THAT(set.refuse(ExitCode::kConfiguration, Aedat4Writer(0, 640, 480).file()),
             Contains("is for 320x240 px, but the events are of 640x480"));

  Aedat4Writer outside(0, 320, 240);
  outside.packet(
      0,
      events_packet({{5, 320, 0, 1}, {6, 0xffff, 0, 1}, {7, 1, 1, 1}, {6, 1, 1, 1}, {INT64_MIN, 1, 1, 0}}));
  const ConvertReport report = set.convert_text(outside.file());
  CHECK(report.events == 1);
  CHECK(report.out_of_range == 2);
  CHECK(report.out_of_order == 1);
  CHECK(report.malformed == 1);

  CHECK_THAT(complaint(ExitCode::kConfiguration, InputFormat::kAedat4, set.input, set / "none"),
             Contains("--kalibr"));
  CHECK_THAT(complaint(ExitCode::kFile, InputFormat::kAedat4, set / "nowhere", set / "none"),
             Contains("cannot be read"));
  write_text_file(set / "prose.txt", "hello world");
  CHECK_THROWS_WITH(guess_format(set / "prose.txt"), Contains("of no known layout"));
  CHECK_THROWS_WITH(guess_format(set / "nowhere"), Contains("cannot be opened"));
}

TEST_CASE("AEDAT4: the real sample decodes whole") {
  const char* given = std::getenv("EGOFOCUS_REAL_DATA");
  const std::filesystem::path real = given ? given : egofocus::test::source_dir() + "/../shared/real";
  const std::filesystem::path sample = real / "streams/tonic_sample.aedat4";
  if (!std::filesystem::exists(sample)) {
    WARN("no real recordings at " << real.string() << " (set EGOFOCUS_REAL_DATA): not exercised");
    return;
  }
  const MappedFile file(sample);
  Aedat4Reader reader(file.bytes(), sample.string());
  REQUIRE(reader.streams().size() == 3);
  CHECK(reader.streams()[0].width_px == 320);
  std::size_t packets = 0;
  std::vector<Event> events;
  std::vector<Aedat4Imu> imu;
  for (; reader.next(); ++packets) {
    reader.append_events(events);
    reader.append_imu(imu);
  }
  // All figures from a decoder of its own, in another language.
  CHECK(packets == 118);
  CHECK_FALSE(reader.unclosed());
  REQUIRE(events.size() == 111954);
  CHECK(events.front().t_us == 1605537493718345);
  CHECK(events.front().x == 154);
  CHECK(events.front().y == 204);
  CHECK(events.back().t_us == 1605537494308262);
  CHECK(std::count_if(events.begin(), events.end(), [](const Event& e) { return e.polarity == 1; }) == 55023);
  REQUIRE(imu.size() == 475);
  CHECK(imu.front().t_us == 1605537493718788);
  CHECK(imu.back().t_us == 1605537494307448);
  CHECK(imu.front().accel_g[1] == Approx(-0.995117188));
  CHECK(imu.front().gyro_deg_s[0] == Approx(0.411987275));

  const Aedat4Set set;
  const ConvertReport report = convert(InputFormat::kAedat4, sample, set / "out", set.options());
  CHECK(report.events == 111954);
  CHECK(report.imu_samples == 475);
  CHECK(report.out_of_order + report.out_of_range + report.malformed + report.imu_dropped == 0);
  CHECK(report.first_us == 718345);
  CHECK(report.last_us == 1308262);
  CHECK(events_of(open_folder(set / "out")).size() == 111954);
}
