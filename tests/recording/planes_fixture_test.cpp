// fixtures/planes is what the simulator makes, and the library reads it as what the simulator meant.
#include <catch2/catch.hpp>
#include <filesystem>
#include <memory>
#include <tuple>

#include "hal/can_motion_decoder.hpp"
#include "hal/candump_decoder.hpp"
#include "hal/evt_decoder.hpp"
#include "recording/folder.hpp"
#include "recording/png_io.hpp"
#include "recording/text_file.hpp"
#include "support/planes_recording.hpp"
#include "support/source_dir.hpp"

using namespace egofocus;

namespace {

const std::filesystem::path kFixture =
    std::filesystem::path(egofocus::test::source_dir()) / "fixtures/planes";

std::vector<Event> decode(std::span<const std::byte> file) {
  RawHeader header;
  REQUIRE(parse_raw_header(file, header).ok());
  REQUIRE(header.size.width_px == 240);
  EvtDecoder decoder(header.format, header.size);
  std::span<const std::byte> rest = file.subspan(header.header_bytes);
  std::vector<Event> events;
  std::vector<Event> block(4096);
  for (Decoded step; !rest.empty() || step.produced == block.size(); rest = rest.subspan(step.consumed)) {
    step = decoder.feed(rest, block);
    events.insert(events.end(), block.begin(), block.begin() + static_cast<std::ptrdiff_t>(step.produced));
  }
  CHECK(decoder.counters().dropped_events == 0);
  for (const std::uint64_t violations : decoder.counters().violations) CHECK(violations == 0);
  return events;
}

}  // namespace

TEST_CASE("the committed fixture is what the simulator makes") {
  sim::PlaneSimulator simulator;
  const std::int64_t until_us = simulator.trajectory().duration_us();
  const recording::MappedFile raw(kFixture / "events.raw");
  std::vector<Event> committed = decode(raw.bytes());
  std::erase_if(committed, [=](const Event& event) { return event.t_us >= until_us; });
  const std::vector<Event> made = simulator.events(until_us);
  REQUIRE(made.size() == committed.size());
  for (std::size_t i = 0; i < made.size(); ++i) {
    REQUIRE(std::tie(made[i].t_us, made[i].x, made[i].y, made[i].polarity) ==
            std::tie(committed[i].t_us, committed[i].x, committed[i].y, committed[i].polarity));
  }
  for (const auto& [name, content] : sim::planes_texts(simulator)) {
    INFO(name << ": make it again with make_planes_fixture, see fixtures/README.md");
    CHECK((content == recording::read_text_file(kFixture / name)));
  }
}

TEST_CASE("the fixture's depth pictures are the simulator's") {
  if (!recording::png_available()) {
    WARN("built without libpng: depth pictures not compared");
    return;
  }
  sim::PlaneSimulator simulator;
  const recording::Folder folder = recording::open_folder(kFixture);
  const std::vector<std::int64_t> ticks = sim::planes_ticks(simulator);
  REQUIRE(folder.truth.size() == ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    REQUIRE(folder.truth[i].t_us == ticks[i]);
    CHECK((recording::read_grey16_png(folder.truth[i].path).pixels == simulator.depth(ticks[i]).pixels));
  }
}

TEST_CASE("the fixture's CAN log says what the trajectory does") {
  const sim::PlaneSimulator simulator;
  const recording::Folder folder = recording::open_folder(kFixture);
  auto dbc = std::make_unique<Dbc>();
  REQUIRE(read_dbc(folder.dbc, {}, *dbc).ok());
  auto decoder = std::make_unique<CanMotionDecoder>();
  REQUIRE(decoder->configure(folder.camera.can.motion, *dbc).ok());

  CandumpDecoder lines;
  std::span<const std::byte> rest = folder.can.bytes();
  const sim::MotionFaults faults;
  std::size_t gyros = 0;
  std::size_t forces = 0;
  std::size_t velocities = 0;
  sim::Vec3 velocity_error{0, 0, 0};
  CanFrame frame;
  while (!rest.empty()) {
    const Decoded step = lines.finish(rest, std::span(&frame, 1));
    rest = rest.subspan(step.consumed);
    if (step.produced == 0) continue;
    MotionSamples samples;
    decoder->feed(frame, samples);
    for (std::size_t i = 0; i < samples.imu_count; ++i) {
      const ImuSample& imu = samples.imu[i];
      if (imu.has_accel) {
        ++forces;
        if (imu.t_us < 400000) CHECK(imu.accel_m_s2[2] == Approx(9.80665).margin(0.4));
        continue;
      }
      ++gyros;
      const sim::BodyTwist body =
          sim::body_twist(simulator.trajectory().twist_at(imu.t_us), folder.camera.config.motion);
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(imu.gyro_rad_s[k] == Approx(body.rate_rad_s[k] + faults.gyro_bias_rad_s[k]).margin(0.02));
      }
    }
    for (std::size_t i = 0; i < samples.odometry_count; ++i) {
      const OdometrySample& odometry = samples.odometry[i];
      REQUIRE(odometry.kind == OdometrySample::Kind::kBodyVelocity);
      ++velocities;
      const sim::BodyTwist body =
          sim::body_twist(simulator.trajectory().twist_at(odometry.t_us), folder.camera.config.motion);
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(odometry.velocity_m_s[k] == Approx(body.velocity_m_s[k]).margin(0.03));
        velocity_error[k] += odometry.velocity_m_s[k] - body.velocity_m_s[k];
      }
    }
  }
  CHECK(lines.counters().unknown == 0);
  CHECK(gyros == 431);
  CHECK(forces == 431);
  CHECK(velocities == 108);
  for (const double sum : velocity_error) CHECK(sum / 108 == Approx(0).margin(0.002));
}

TEST_CASE("the fixture stays small") {
  std::uintmax_t bytes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(kFixture)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  CHECK(bytes <= 3 * 1024 * 1024);
}
