#include "recording/recording_source.hpp"

#include <algorithm>
#include <vector>

#include "hal/dbc.hpp"
#include "hal/evt_decoder.hpp"

namespace egofocus::recording {
namespace {

constexpr std::size_t kBatch = 4096;

}  // namespace

std::unique_ptr<CanMotionDecoder> make_can_decoder(const CanSetup& can, std::string_view text,
                                                   const std::filesystem::path& file) {
  const auto dbc = std::make_unique<Dbc>();
  require(read_dbc(text, {}, *dbc), file.string(), ExitCode::kBadFile);
  auto decoder = std::make_unique<CanMotionDecoder>();
  require(decoder->configure(can.motion, *dbc), file.string());
  return decoder;
}

std::unique_ptr<CanMotionDecoder> make_can_decoder(const Folder& folder) {
  return make_can_decoder(folder.camera.can, folder.dbc, folder.path / folder.camera.can.dbc);
}

void require(const Status& status, const std::string& where, ExitCode code) {
  if (status.ok()) return;
  char text[320];
  status.describe(text);
  throw Error(code, where, text);
}

RecordingSource::RecordingSource(const Folder& folder, CanTap tap) : folder_(folder) {
  ReplayStreams streams;
  streams.events_raw = folder_.events.bytes();
  if (folder_.camera.config.motion.source == MotionSource::kPoses) {
    streams.poses_txt = folder_.pose_file.bytes();
  } else {
    streams.can_log = folder_.can.bytes();
    can_motion_ = make_can_decoder(folder_);
    streams.can_motion = can_motion_.get();
    streams.can_lag_us = can_lag_us(folder_.camera.can.motion);
    streams.can_tap = tap;
  }
  scan_events();
  source_ = std::make_unique<ReplaySource>(streams);
}

void RecordingSource::scan_events() {
  const std::string where = (folder_.path / "events.raw").string();
  require(parse_raw_header(folder_.events.bytes(), header_), where, ExitCode::kBadFile);
  const Intrinsics& camera = folder_.camera.config.camera.intrinsics;
  if (header_.size.width_px != camera.width_px || header_.size.height_px != camera.height_px) {
    throw Error(ExitCode::kConfiguration, (folder_.path / "camera.toml").string(),
                "says " + std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px) +
                    " px, but " + where + " is " + std::to_string(header_.size.width_px) + "x" +
                    std::to_string(header_.size.height_px) + ". Use the calibration of this sensor.");
  }
  const std::span<const std::byte> words = folder_.events.bytes().subspan(header_.header_bytes);
  cut_off_bytes_ = words.size() % word_bytes(header_.format);
  EvtDecoder scanner(header_.format, header_.size);
  std::vector<Event> batch(kBatch);
  for (std::span<const std::byte> left = words;;) {
    const Decoded done = scanner.feed(left, batch);
    if (done.produced > 0 && event_count_ == 0) first_event_us_ = batch[0].t_us;
    for (std::size_t i = 0; i < done.produced; ++i) last_event_us_ = std::max(last_event_us_, batch[i].t_us);
    event_count_ += done.produced;
    left = left.subspan(done.consumed);
    if (done.produced == 0) break;
  }
  if (event_count_ == 0)
    throw Error(ExitCode::kNoEvents, where, "holds no events. Was the recording stopped too early?");
}

std::int64_t RecordingSource::default_first_tick_us(double rate_hz) const {
  if (!folder_.truth.empty()) return folder_.truth.front().t_us;
  return first_event_us_ + static_cast<std::int64_t>(1e6 / rate_hz);
}

}  // namespace egofocus::recording
