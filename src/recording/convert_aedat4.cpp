#include "recording/convert_aedat4.hpp"

#include <algorithm>

#include "recording/aedat4_reader.hpp"
#include "recording/error.hpp"
#include "recording/kalibr.hpp"
#include "recording/mapped_file.hpp"
#include "recording/recording_builder.hpp"

namespace egofocus::recording {
namespace {

constexpr std::size_t kEventsAtOnce = 1u << 16;

/// The `index`th stream of a type; nullptr if there is none.
const Aedat4Stream* find_stream(const Aedat4Reader& reader, std::string_view type, std::size_t index) {
  for (const Aedat4Stream& stream : reader.streams()) {
    if (stream.type == type && index-- == 0) return &stream;
  }
  return nullptr;
}

void set_camera(const Aedat4Stream& stream, const ConvertOptions& options, std::size_t index,
                RecordingBuilder& builder) {
  const std::vector<KalibrCamera> cameras = read_kalibr(options.kalibr);
  if (cameras.size() <= index)
    throw Error(ExitCode::kConfiguration, options.kalibr.string(), "has no cam1, the right event camera.");
  const KalibrCamera& camera = cameras[index];
  const Intrinsics& in = camera.model.intrinsics;
  if (stream.width_px > 0 && (stream.width_px != in.width_px || stream.height_px != in.height_px)) {
    throw Error(ExitCode::kConfiguration, options.kalibr.string(),
                "is for " + std::to_string(in.width_px) + "x" + std::to_string(in.height_px) +
                    " px, but the events are of " + std::to_string(stream.width_px) + "x" +
                    std::to_string(stream.height_px) + ". Use the calibration of this sensor.");
  }
  builder.set_camera(camera.model, options.kalibr.string());
  if (camera.camera_from_imu) {
    set_body(builder.camera.config.motion, *camera.camera_from_imu);
  } else {
    builder.report.remarks.emplace_back(kUnknownImuAxes);
  }
}

ImuReading reading_of(const Aedat4Imu& sample) {
  ImuReading reading;
  reading.t_us = sample.t_us;
  std::copy(sample.gyro_deg_s, sample.gyro_deg_s + 3, reading.gyro);
  std::copy(sample.accel_g, sample.accel_g + 3, reading.accel);
  return reading;
}

}  // namespace

ConvertReport convert_aedat4(const std::filesystem::path& input, const std::filesystem::path& output,
                             const ConvertOptions& options) {
  RecordingBuilder builder(output, options);
  const MappedFile file(input);
  if (file.bytes().empty()) throw Error(ExitCode::kBadFile, input.string(), "is empty.");
  Aedat4Reader reader(file.bytes(), input.string());
  const std::size_t index = options.camera == CameraSide::kRight ? 1 : 0;
  const Aedat4Stream* const event_stream = find_stream(reader, "EVTS", index);
  const Aedat4Stream* const imu_stream = find_stream(reader, "IMUS", index);
  if (!event_stream)
    throw Error(ExitCode::kNoEvents, input.string(), "lists no stream of events for this camera.");
  if (options.kalibr.empty()) {
    throw Error(ExitCode::kConfiguration, input.string(),
                "AEDAT4 files have no calibration. Give one with --kalibr FILE.");
  }
  set_camera(*event_stream, options, index, builder);
  if (!options.poses.empty()) builder.read_poses(options.poses);

  builder.camera.can = imu_can_setup(CanUnit::kDegPerSecond, CanUnit::kStandardGravity);
  std::vector<Event> events;
  std::vector<Aedat4Imu> samples;  // those before the first event wait for the origin of time
  const auto hand_over = [&] {
    builder.add_events(events);
    events.clear();
    if (builder.report.events == 0) return;
    for (const Aedat4Imu& sample : samples) builder.add_imu(reading_of(sample));
    samples.clear();
  };
  while (reader.next()) {
    if (reader.stream() == event_stream->id) reader.append_events(events);
    if (imu_stream && reader.stream() == imu_stream->id) reader.append_imu(samples);
    if (events.size() >= kEventsAtOnce) hand_over();
    if (options.progress) options.progress(reader.position(), reader.end());
  }
  hand_over();
  for (const Aedat4Stream& stream : reader.streams()) {
    if (&stream != event_stream && &stream != imu_stream) builder.report.left_out.push_back(stream.type);
  }
  if (reader.unclosed()) {
    builder.report.remarks.push_back("The recorder did not close the file; " +
                                     std::to_string(reader.cut_off_bytes()) +
                                     " bytes of a last packet are left out.");
  }
  return builder.finish(input.string());
}

}  // namespace egofocus::recording
