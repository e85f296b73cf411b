#include "hal/v4l2_source.hpp"

#include <poll.h>

#include <string_view>

#include "hal/device_status.hpp"
#include "hal/v4l2_text.hpp"

namespace egofocus {
namespace {

constexpr int kMostFailures = 100;  // polls in a row that only report an error
constexpr std::int64_t kErrorPause_us = 1'000;
constexpr std::int64_t kOldestStamp_us = 10'000'000;

std::int64_t lower_of(std::int64_t a, std::int64_t b) noexcept {
  return a < b ? a : b;
}

}  // namespace

Source V4l2CameraSource::source() noexcept {
  return {.self = this,
          .name = "v4l2 camera",
          .start = [](void* self) noexcept { return static_cast<V4l2CameraSource*>(self)->start(); },
          .poll =
              [](void* self, Inlets& inlets, std::int64_t, std::int64_t timeout_us) noexcept {
                return static_cast<V4l2CameraSource*>(self)->poll(inlets, timeout_us);
              },
          .stop = [](void* self) noexcept { static_cast<V4l2CameraSource*>(self)->stop(); }};
}

Status V4l2CameraSource::open() noexcept {
  close();
  Status status = open_v4l2_camera(settings_, node_, info_);
  if (status.ok() && copy_.size() < buffer_bytes(settings_)) {
    status = {StatusCode::kArenaTooSmall, "copy of a V4L2 buffer", static_cast<std::int64_t>(copy_.size()),
              static_cast<std::int64_t>(buffer_bytes(settings_))};
  }
  if (!status.ok()) {
    close();
    return status;
  }
  ++counts_.opened;
  return {};
}

Status V4l2CameraSource::start() noexcept {
  if (!node_.is_open()) {
    if (const Status status = open(); !status.ok()) return status;
  }
  was_started_ = true;
  if (const Status status =
          buffers_.start(info_.is_multiplanar, static_cast<std::uint32_t>(settings_.buffers));
      !status.ok()) {
    close();
    return status;
  }
  // The same sensor after a loss, even where another one of its kind is there as well.
  if (settings_.device[0] == '\0') V4l2Text(settings_.device).text(info_.route.sensor);
  samples_.restart(info_.format, info_.size, settings_.device_time);
  has_sequence_ = false;
  failures_in_a_row_ = 0;
  last_data_us_ = now_us();
  counts_.is_streaming = true;
  publish();
  return {};
}

Delivery V4l2CameraSource::poll(Inlets& inlets, std::int64_t timeout_us) noexcept {
  if (!was_started_) {
    return {.watermark_us = samples_.watermark_us(),
            .ended = false,
            .status = {StatusCode::kBadState, "poll() of a V4L2 camera before start()"}};
  }
  if (counts_.is_streaming) {
    stream(inlets, timeout_us);
  } else if (settings_.reopen) {
    look_again(timeout_us);
  }
  publish();
  Delivery told{.watermark_us = samples_.watermark_us(), .ended = false, .status = {}};
  if (!counts_.is_streaming && !settings_.reopen) told.status = counts_.last_error;
  return told;
}

void V4l2CameraSource::stream(Inlets& inlets, std::int64_t timeout_us) noexcept {
  const int ready = node_.wait(timeout_us);
  if (ready == -EINTR) return;
  if (ready < 0) return lose(-ready, "waiting for V4L2 buffers");
  const std::uint64_t before = counts_.buffers;
  if (const int code = take_all(inlets); code < 0) return lose(-code, "taking V4L2 buffers");
  if (counts_.buffers != before) {
    failures_in_a_row_ = 0;
    return;
  }
  if ((ready & (POLLERR | POLLHUP | POLLNVAL)) != 0) {
    ++counts_.poll_errors;
    if (++failures_in_a_row_ >= kMostFailures) return lose(EIO, "the V4L2 stream reports errors only");
    io_.wait(io_.self, -1, lower_of(kErrorPause_us, timeout_us));
  }
  const std::int64_t silence_us = std::int64_t{settings_.silence_ms} * 1000;
  if (silence_us > 0 && now_us() - last_data_us_ > silence_us) lose(ETIMEDOUT, "the V4L2 stream is silent");
}

// What the driver has filled, once around at most: a sensor that is faster than we are must not keep us here.
int V4l2CameraSource::take_all(Inlets& inlets) noexcept {
  for (std::size_t i = buffers_.count(); i > 0; --i) {
    V4l2Filled filled;
    const int code = buffers_.take(filled);
    if (code == -EAGAIN || code == -EINTR) return 0;
    if (code < 0) return code;
    if (const int error = take(filled, inlets); error < 0) return error;
  }
  return 0;
}

int V4l2CameraSource::take(const V4l2Filled& filled, Inlets& inlets) noexcept {
  ++counts_.buffers;
  last_data_us_ = now_us();
  retry_.worked();
  check_sequence(filled.sequence);
  const std::size_t valid = copy_valid(filled);
  if (const int code = buffers_.give_back(filled.index); code < 0) return code;
  if (valid > 0) samples_.take(copy_.first(valid), time_of(filled), info_.has_marker, inlets);
  return 0;
}

// The bytes that may be decoded, copied; 0: none, and why is counted.
std::size_t V4l2CameraSource::copy_valid(const V4l2Filled& filled) noexcept {
  if (filled.has_error || filled.is_wrong || filled.bytes.size() > copy_.size()) {
    ++(filled.has_error ? counts_.damaged : counts_.wrong);
    samples_.resync();
    return 0;
  }
  std::size_t valid = filled.bytes.size();
  bool is_marked = true;
  if (info_.has_marker) {
    valid = EvtFrameEnd(info_.format).copy(filled.bytes, copy_, is_marked);
  } else if (valid > 0) {
    __builtin_memcpy(copy_.data(), filled.bytes.data(), valid);
  }
  if (valid == 0) {
    ++counts_.empty;
    return 0;
  }
  if (!is_marked && !settings_.decode_unmarked) {
    ++counts_.unmarked_refused;
    samples_.resync();
    return 0;
  }
  counts_.unmarked_decoded += !is_marked;
  ++counts_.decoded;
  counts_.bytes += valid;
  return valid;
}

// Drivers that do not count leave the sequence as it is.
void V4l2CameraSource::check_sequence(std::uint32_t sequence) noexcept {
  const std::uint32_t step = sequence - sequence_;
  if (has_sequence_ && step > 1) {
    // A step back is another numbering, with an unknown loss.
    if (step < 0x80000000u) counts_.lost_buffers += step - 1;
    samples_.resync();
  }
  has_sequence_ = true;
  sequence_ = sequence;
}

std::int64_t V4l2CameraSource::time_of(const V4l2Filled& filled) noexcept {
  const std::int64_t taken_us = last_data_us_;
  if (filled.has_stamp && filled.stamp_us <= taken_us && taken_us - filled.stamp_us <= kOldestStamp_us)
    return filled.stamp_us;
  ++counts_.without_stamp;
  return taken_us;
}

void V4l2CameraSource::lose(int error, const char* subject) noexcept {
  ++counts_.lost;
  counts_.last_error = {StatusCode::kDeviceLost, subject, error};
  close();
  retry_.failed(now_us());
}

void V4l2CameraSource::look_again(std::int64_t timeout_us) noexcept {
  const std::int64_t at_us = now_us();
  if (at_us < retry_.next_us()) {
    clock_.sleep_until_us(clock_.self, lower_of(retry_.next_us(), at_us + timeout_us));
    return;
  }
  if (const Status status = start(); !status.ok()) {
    ++counts_.refused;
    counts_.last_error = status;
    retry_.failed(now_us());
  }
}

void V4l2CameraSource::stop() noexcept {
  was_started_ = false;
  close();
  publish();
}

void V4l2CameraSource::close() noexcept {
  buffers_.stop();
  node_.close();
  counts_.is_streaming = false;
}

void V4l2CameraSource::publish() noexcept {
  counts_.samples = samples_.counters();
  counts_.evt = samples_.evt();
  counts_.clock = samples_.clock().counters();
  published_.publish(counts_);
}

V4l2CameraCounters V4l2CameraSource::counters() const noexcept {
  V4l2CameraCounters counters;
  static_cast<void>(published_.read(counters));
  return counters;
}

}  // namespace egofocus
