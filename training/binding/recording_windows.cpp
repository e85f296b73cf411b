#include "recording_windows.hpp"

#include <algorithm>

#include "hal/dbc.hpp"
#include "recording/error.hpp"
#include "recording/replay.hpp"

namespace egofocus::training {
namespace {

using recording::ExitCode;

std::unique_ptr<CanMotionDecoder> can_decoder(const recording::Folder& folder) {
  if (folder.camera.config.motion.source == MotionSource::kPoses) return nullptr;
  const std::string where = (folder.path / folder.camera.can.dbc).string();
  const auto dbc = std::make_unique<Dbc>();
  recording::require(read_dbc(folder.dbc, {}, *dbc), where, ExitCode::kBadFile);
  auto decoder = std::make_unique<CanMotionDecoder>();
  recording::require(decoder->configure(folder.camera.can.motion, *dbc), where);
  return decoder;
}

ReplayStreams streams_of(const recording::Folder& folder, CanMotionDecoder* can_motion) {
  ReplayStreams streams;
  streams.events_raw = folder.events.bytes();
  if (can_motion == nullptr) {
    streams.poses_txt = folder.pose_file.bytes();
  } else {
    streams.can_log = folder.can.bytes();
    streams.can_motion = can_motion;
    streams.can_lag_us = can_lag_us(folder.camera.can.motion);
  }
  return streams;
}

}  // namespace

RecordingWindows::Rings::Rings(const RingConfig& config)
    : events(config.events),
      imu(config.imu),
      odometry(config.odometry),
      poses(config.poses),
      ends{SpscRing<Event>(events), SpscRing<ImuSample>(imu), SpscRing<OdometrySample>(odometry),
           SpscRing<PoseSample>(poses)} {}

RecordingWindows::RecordingWindows(recording::Folder folder)
    : folder_(std::move(folder)),
      can_motion_(can_decoder(folder_)),
      rings_(folder_.camera.config.rings),
      source_(std::make_unique<ReplaySource>(streams_of(folder_, can_motion_.get()))),
      stack_(folder_.camera.config, {}) {
  ego_motion_ = std::make_unique<EgoMotion>(folder_.camera.config.motion);
  recording::require(source_->start(), folder_.path.string(), ExitCode::kBadFile);
}

std::uint64_t RecordingWindows::drain(std::int64_t tick_us) {
  std::uint64_t taken = 0;
  const auto take = [&](auto& ring, const auto& use) {
    for (;;) {
      const auto ready = ring.peek(1024);
      std::size_t n = 0;
      while (n < ready.size() && ready[n].t_us <= tick_us) use(ready[n++]);
      ring.release(n);
      taken += n;
      if (n == 0 || n < ready.size()) return;
    }
  };
  take(rings_.ends.events, [this](const Event& event) {
    if (stack_.add(event)) kept_.push_back(event);
    forget_before(event.t_us - folder_.camera.config.window.max_age_us);
  });
  take(rings_.ends.imu, [this](const ImuSample& sample) { ego_motion_->add(sample); });
  take(rings_.ends.odometry, [this](const OdometrySample& sample) { ego_motion_->add(sample); });
  take(rings_.ends.poses, [this](const PoseSample& sample) { ego_motion_->add(sample); });
  return taken;
}

void RecordingWindows::forget_before(std::int64_t t_us) {
  while (!kept_.empty() && kept_.front().t_us < t_us) kept_.pop_front();
}

bool RecordingWindows::tick(std::int64_t tick_us) {
  if (tick_us <= tick_us_) {
    throw recording::Error(ExitCode::kUsage, folder_.path.string(), "ticks must rise in time.");
  }
  Inlets inlets(rings_.ends);
  for (int idle = 0; idle < 100;) {
    const Delivery delivery = source_->poll(inlets, tick_us);
    recording::require(delivery.status, folder_.path.string(), ExitCode::kBadFile);
    idle = drain(tick_us) > 0 ? 0 : idle + 1;
    if (delivery.ended || delivery.watermark_us >= tick_us) break;
  }
  static_cast<void>(drain(tick_us));
  tick_us_ = tick_us;
  ego_motion_->advance(tick_us);
  const std::int64_t longest_us = tick_us - folder_.camera.config.window.max_age_us;
  forget_before(longest_us);
  return stack_.run(std::max(longest_us, ego_motion_->earliest_us()), tick_us,
                    [this](std::int64_t begin_us, std::int64_t end_us, MotionTrack& out) {
                      return ego_motion_->track(begin_us, end_us, out);
                    });
}

std::vector<MotionSample> RecordingWindows::motion() const {
  std::vector<MotionSample> samples(EgoMotion::kMaxSamples);
  const std::int64_t longest_us = tick_us_ - folder_.camera.config.window.max_age_us;
  const std::int64_t oldest_us = std::max(longest_us, ego_motion_->earliest_us());
  samples.resize(oldest_us < tick_us_
                     ? static_cast<std::size_t>(ego_motion_->samples(oldest_us, tick_us_, samples))
                     : 0);
  return samples;
}

std::vector<Event> RecordingWindows::events() const {
  return {kept_.begin(), kept_.end()};
}

}  // namespace egofocus::training
