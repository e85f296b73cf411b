// What the tests of the converters ask of a converted recording, read back as a replay would read it.
#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "hal/can_motion_decoder.hpp"
#include "hal/candump_decoder.hpp"
#include "hal/evt_decoder.hpp"
#include "recording/convert.hpp"
#include "recording/error.hpp"
#include "recording/folder.hpp"

namespace egofocus::test {

inline std::vector<Event> events_of(const recording::Folder& folder) {
  RawHeader header;
  REQUIRE(parse_raw_header(folder.events.bytes(), header).ok());
  EvtDecoder decoder(header.format, header.size);
  std::vector<Event> events(1u << 20);
  const Decoded step = decoder.feed(folder.events.bytes().subspan(header.header_bytes), events);
  REQUIRE(step.produced < events.size());
  events.resize(step.produced);
  return events;
}

/// Gyro and accelerometer samples, as they leave the bus decoder.
inline std::vector<ImuSample> imu_of(const recording::Folder& folder) {
  const auto dbc = std::make_unique<Dbc>();
  REQUIRE(read_dbc(folder.dbc, {}, *dbc).ok());
  CanMotionDecoder motion;
  REQUIRE(motion.configure(folder.camera.can.motion, *dbc).ok());
  CandumpDecoder decoder;
  std::vector<CanFrame> frames(4096);
  const Decoded step = decoder.finish(folder.can.bytes(), frames);
  REQUIRE(step.produced < frames.size());
  std::vector<ImuSample> samples;
  MotionSamples out;
  for (std::size_t i = 0; i < step.produced; ++i) {
    motion.feed(frames[i], out);
    samples.insert(samples.end(), out.imu, out.imu + out.imu_count);
  }
  return samples;
}

inline void check_same_events(const std::vector<Event>& got, const std::vector<Event>& wanted) {
  REQUIRE(got.size() == wanted.size());
  std::size_t different = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    const Event& a = got[i];
    const Event& b = wanted[i];
    different += a.t_us != b.t_us || a.x != b.x || a.y != b.y || a.polarity != b.polarity;
  }
  CHECK(different == 0);
}

/// The message of a conversion that must fail with this code, and leave nothing behind.
inline std::string complaint(recording::ExitCode code, recording::InputFormat format,
                             const std::filesystem::path& input, const std::filesystem::path& output,
                             const recording::ConvertOptions& options = {}) {
  try {
    (void)recording::convert(format, input, output, options);
  } catch (const recording::Error& error) {
    CHECK(error.exit_code() == static_cast<int>(code));
    CHECK_FALSE(recording::is_recording(output));
    CHECK_FALSE(std::filesystem::exists(output.string() + ".partial"));
    CHECK(std::string(error.what()).find('\n') == std::string::npos);
    return error.what();
  }
  return "no complaint";
}

/// Events of a moving bar: sorted, both polarities, every 50 us, some in one microsecond.
inline std::vector<Event> some_events(std::size_t count, int width, int height, std::int64_t first_us) {
  std::vector<Event> events;
  for (std::size_t i = 0; i < count; ++i) {
    events.push_back({first_us + static_cast<std::int64_t>(i / 3) * 50,
                      static_cast<std::uint16_t>(i * 7 % static_cast<std::size_t>(width)),
                      static_cast<std::uint16_t>(i * 13 % static_cast<std::size_t>(height)),
                      static_cast<std::uint8_t>(i % 2)});
  }
  return events;
}

}  // namespace egofocus::test
