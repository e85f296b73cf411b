#include "hal/replay_source.hpp"

namespace egofocus {
namespace {

std::int64_t lower_of(std::int64_t a, std::int64_t b) noexcept {
  return a < b ? a : b;
}

// Times of untrusted files reach both ends of the type: neither sum nor difference may overflow.
std::int64_t shifted(std::int64_t t_us, std::int64_t by_us) noexcept {
  std::int64_t sum = 0;
  if (__builtin_add_overflow(t_us, by_us, &sum)) return by_us < 0 ? INT64_MIN : INT64_MAX;
  return sum;
}

// Decodes the next batch of a text file; at the end of the file a last line without LF counts as whole.
template <typename Decoder, typename Sample>
std::size_t read_text(Decoder& decoder, std::span<const std::byte>& left, std::span<Sample> out) noexcept {
  while (!left.empty()) {
    Decoded done = decoder.feed(left, out);
    if (done.consumed == 0) done = decoder.finish(left, out);
    left = left.subspan(done.consumed);
    if (done.produced > 0) return done.produced;
  }
  return 0;
}

// Pushes what is due, batch by batch. Returns the time up to which all of this stream is out; INT64_MAX at
// its end.
template <typename Staged, typename Refill, typename Room>
std::int64_t pump(Staged& staged, std::int64_t until_us, Inlets& inlets, std::uint64_t& pushed, Refill refill,
                  Room room) noexcept {
  while (!staged.empty() || refill()) {
    const std::size_t first = staged.next;
    const std::size_t free = room();
    std::size_t end = first;
    while (end < staged.count && end - first < free && staged.items[end].t_us <= until_us) ++end;
    if (end == first) {
      const std::int64_t t_us = staged.items[first].t_us;
      return t_us > until_us ? until_us : shifted(t_us, -1);
    }
    const std::size_t taken = inlets.push(std::span(staged.items).subspan(first, end - first));
    staged.next += taken;
    pushed += taken;
  }
  return INT64_MAX;
}

// Pushes the samples that are due, in their order, and closes the gaps that they leave. Returns the oldest
// time that found no room, or INT64_MAX.
template <typename Sample>
std::int64_t push_due(std::span<Sample> staged, std::size_t& count, std::int64_t until_us, std::size_t room,
                      Inlets& inlets, std::uint64_t& pushed) noexcept {
  std::int64_t oldest_left = INT64_MAX;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Sample sample = staged[i];
    if (sample.t_us <= until_us && room > 0) {
      pushed += inlets.push(std::span<const Sample>(&sample, 1));
      --room;
      continue;
    }
    if (sample.t_us <= until_us && sample.t_us < oldest_left) oldest_left = sample.t_us;
    staged[kept++] = sample;
  }
  count = kept;
  return oldest_left;
}

}  // namespace

Source ReplaySource::source() noexcept {
  return {
      .self = this,
      .name = "replay",
      .start = [](void* self) noexcept { return static_cast<ReplaySource*>(self)->start(); },
      .poll = [](void* self, Inlets& inlets, std::int64_t until_us,
                 std::int64_t) noexcept { return static_cast<ReplaySource*>(self)->poll(inlets, until_us); },
      .stop = [](void*) noexcept {}};
}

Status ReplaySource::start() noexcept {
  if (!streams_.can_log.empty() && streams_.can_motion == nullptr) {
    return {StatusCode::kBadState, "a CAN log needs a configured CanMotionDecoder"};
  }
  header_ = {};
  if (!streams_.events_raw.empty()) {
    if (const Status status = parse_raw_header(streams_.events_raw, header_); !status.ok()) return status;
  }
  evt_ = EvtDecoder(header_.format, header_.size);
  candump_ = {};
  pose_text_ = {};
  events_left_ = streams_.events_raw.subspan(header_.header_bytes);
  can_left_ = streams_.can_log;
  poses_left_ = streams_.poses_txt;
  events_.count = events_.next = 0;
  poses_.count = poses_.next = 0;
  imu_count_ = odometry_count_ = 0;
  has_frame_ = false;
  pushed_ = {};
  return {};
}

Delivery ReplaySource::poll(Inlets& inlets, std::int64_t until_us) noexcept {
  const std::int64_t events_us = pump(
      events_, until_us, inlets, pushed_.events_pushed, [this] { return refill_events(); },
      [&inlets] { return inlets.event_room(); });
  const std::int64_t poses_us = pump(
      poses_, until_us, inlets, pushed_.poses_pushed, [this] { return refill_poses(); },
      [&inlets] { return inlets.pose_room(); });
  const std::int64_t motion_us = pump_motion(inlets, until_us);
  const std::int64_t all_us = lower_of(lower_of(events_us, poses_us), motion_us);
  return {.watermark_us = lower_of(all_us, until_us), .ended = all_us == INT64_MAX, .status = {}};
}

bool ReplaySource::refill_events() noexcept {
  const Decoded done = evt_.feed(events_left_, events_.items);
  events_left_ = events_left_.subspan(done.consumed);
  events_.next = 0;
  events_.count = done.produced;
  for (std::size_t i = 0; i < done.produced; ++i) {
    events_.items[i].t_us = shifted(events_.items[i].t_us, streams_.events_offset_us);
  }
  return done.produced > 0;
}

bool ReplaySource::refill_poses() noexcept {
  poses_.next = 0;
  poses_.count = read_text(pose_text_, poses_left_, std::span<PoseSample>(poses_.items));
  return poses_.count > 0;
}

bool ReplaySource::read_frame() noexcept {
  if (!has_frame_) has_frame_ = read_text(candump_, can_left_, std::span<CanFrame>(&frame_, 1)) > 0;
  return has_frame_;
}

bool ReplaySource::is_full() const noexcept {
  return imu_count_ + 2 > kStagedMotion || odometry_count_ + 2 > kStagedMotion;
}

std::int64_t ReplaySource::push_motion(Inlets& inlets, std::int64_t until_us) noexcept {
  return lower_of(push_due(std::span<ImuSample>(imu_), imu_count_, until_us, inlets.imu_room(), inlets,
                           pushed_.imu_pushed),
                  push_due(std::span<OdometrySample>(odometry_), odometry_count_, until_us,
                           inlets.odometry_room(), inlets, pushed_.odometry_pushed));
}

// A frame that comes later in the log may complete a sample that is older than one already there. So frames
// are read until none can bring a sample of `until_us` or before, and the samples that turn out later wait.
std::int64_t ReplaySource::pump_motion(Inlets& inlets, std::int64_t until_us) noexcept {
  for (;;) {
    const std::int64_t stuck_us = push_motion(inlets, until_us);
    if (!read_frame()) {
      if (stuck_us != INT64_MAX) return shifted(stuck_us, -1);
      return imu_count_ + odometry_count_ == 0 ? INT64_MAX : until_us;
    }
    const std::int64_t next_us = shifted(frame_.t_us, -streams_.can_lag_us);  // no sample to come is older
    if (next_us > until_us) return stuck_us == INT64_MAX ? until_us : shifted(stuck_us, -1);
    // More samples wait than a bus brings within its lag: better early than never.
    if (is_full() && push_motion(inlets, INT64_MAX) != INT64_MAX && is_full()) {
      return shifted(lower_of(stuck_us, next_us), -1);
    }
    has_frame_ = false;
    MotionSamples samples;
    if (streams_.can_tap.frame != nullptr) streams_.can_tap.frame(streams_.can_tap.self, frame_);
    streams_.can_motion->feed(frame_, samples);
    for (std::size_t i = 0; i < samples.imu_count; ++i) imu_[imu_count_++] = samples.imu[i];
    for (std::size_t i = 0; i < samples.odometry_count; ++i)
      odometry_[odometry_count_++] = samples.odometry[i];
  }
}

ReplayCounters ReplaySource::counters() const noexcept {
  ReplayCounters all = pushed_;
  all.events = evt_.counters();
  all.can_log = candump_.counters();
  if (streams_.can_motion != nullptr) all.can_motion = streams_.can_motion->counters();
  all.poses = pose_text_.counters();
  return all;
}

}  // namespace egofocus
