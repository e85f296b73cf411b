#include "recording/replay.hpp"

#include <algorithm>
#include <string>

#include "hal/dbc.hpp"
#include "hal/raw_header.hpp"
#include "recording/error.hpp"

namespace egofocus::recording {
namespace {

constexpr std::size_t kBatch = 4096;

}  // namespace

std::unique_ptr<CanMotionDecoder> make_can_decoder(const Folder& folder) {
  const std::string where = (folder.path / folder.camera.can.dbc).string();
  const auto dbc = std::make_unique<Dbc>();
  require(read_dbc(folder.dbc, {}, *dbc), where, ExitCode::kBadFile);
  auto decoder = std::make_unique<CanMotionDecoder>();
  require(decoder->configure(folder.camera.can.motion, *dbc), where);
  return decoder;
}

void require(const Status& status, const std::string& where, ExitCode code) {
  if (status.ok()) return;
  char text[320];
  status.describe(text);
  throw Error(code, where, text);
}

Replay::Replay(Folder folder) : folder_(std::move(folder)) {
  const std::string camera = (folder_.path / "camera.toml").string();
  ReplayStreams streams;
  streams.events_raw = folder_.events.bytes();
  if (config().motion.source == MotionSource::kPoses) {
    streams.poses_txt = folder_.pose_file.bytes();
  } else {
    streams.can_log = folder_.can.bytes();
    can_motion_ = make_can_decoder(folder_);
    streams.can_motion = can_motion_.get();
    streams.can_lag_us = can_lag_us(folder_.camera.can.motion);
  }
  scan_events();
  require(Engine::required_arena(config(), arena_bytes_), camera);
  const std::size_t bytes = arena_bytes_.all;
  arena_.reset(std::aligned_alloc(64, bytes));
  if (!arena_)
    throw Error(ExitCode::kInternal, "no memory for an arena of " + std::to_string(bytes) + " bytes");
  require(engine_.configure(config(), {static_cast<std::byte*>(arena_.get()), bytes}), camera);
  source_ = std::make_unique<ReplaySource>(streams);
  require(engine_.attach(source_->source()), "replay", ExitCode::kInternal);
}

// Once through all events: first and last time, and a header that is refused before anything runs.
void Replay::scan_events() {
  const std::string where = (folder_.path / "events.raw").string();
  RawHeader header;
  require(parse_raw_header(folder_.events.bytes(), header), where, ExitCode::kBadFile);
  const Intrinsics& camera = config().camera.intrinsics;
  if (header.size.width_px != camera.width_px || header.size.height_px != camera.height_px) {
    throw Error(ExitCode::kConfiguration, (folder_.path / "camera.toml").string(),
                "says " + std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px) +
                    " px, but " + where + " is " + std::to_string(header.size.width_px) + "x" +
                    std::to_string(header.size.height_px) + ". Use the calibration of this sensor.");
  }
  reader_.emplace(folder_.events.bytes(), header);
  const std::span<const std::byte> words = folder_.events.bytes().subspan(header.header_bytes);
  cut_off_bytes_ = words.size() % word_bytes(header.format);
  EvtDecoder scanner(header.format, header.size);
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

std::int64_t Replay::default_first_tick_us() const {
  if (!folder_.truth.empty()) return folder_.truth.front().t_us;
  return first_event_us_ + static_cast<std::int64_t>(1e6 / config().rate.rate_hz);
}

void Replay::start(std::int64_t first_tick_us) {
  require(engine_.start(ClockKind::kVirtual, first_tick_us), folder_.path.string(), ExitCode::kBadFile);
}

void Replay::set_next_tick(std::int64_t t_us) {
  require(engine_.set_next_tick(t_us), folder_.path.string(), ExitCode::kInternal);
}

bool Replay::tick(DepthFrame& frame) {
  if (engine_.next_tick_us() > last_event_us_) return false;
  return engine_.tick() && engine_.newest(frame);
}

std::span<const Event> Replay::events_between(std::int64_t first_us, std::int64_t last_us) {
  return reader_->between(first_us, last_us);
}

void check_motion(Replay& replay) {
  const TickCounters ticks = replay.engine().health().ticks;
  if (ticks.run == 0 || ticks.no_motion < ticks.run) return;
  const bool poses = replay.config().motion.source == MotionSource::kPoses;
  throw Error(ExitCode::kMotion, (replay.folder().path / (poses ? "poses.txt" : "can.log")).string(),
              "no motion before any of the " + std::to_string(ticks.run) + " ticks. " +
                  (poses ? "Choose a later tick with --first-tick-us."
                         : "Is it a `candump -L` log with the frames that camera.toml and the DBC name?"));
}

}  // namespace egofocus::recording
