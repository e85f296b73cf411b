#include "hal/usb_camera_source.hpp"

#include <string_view>

namespace egofocus {
namespace {

constexpr std::int64_t kSilence_us = 1'000'000;  // every family sends times without events
constexpr std::int64_t kDropsEvery_us = 1'000'000;
constexpr int kMostFailures = 8;
constexpr int kCancelWaits = 100;  // of 10 ms
constexpr std::int64_t kCancelWait_us = 10'000;

std::int64_t lower_of(std::int64_t a, std::int64_t b) noexcept {
  return a < b ? a : b;
}

}  // namespace

Source UsbCameraSource::source() noexcept {
  return {.self = this,
          .name = "usb camera",
          .start = [](void* self) noexcept { return static_cast<UsbCameraSource*>(self)->start(); },
          .poll =
              [](void* self, Inlets& inlets, std::int64_t, std::int64_t timeout_us) noexcept {
                return static_cast<UsbCameraSource*>(self)->poll(inlets, timeout_us);
              },
          .stop = [](void* self) noexcept { static_cast<UsbCameraSource*>(self)->stop(); }};
}

Status UsbCameraSource::start() noexcept {
  if (!usb_.is_open()) {
    if (Status status = open(); !status.ok()) return status;
  }
  was_started_ = true;
  steps_.clear();
  if (Status status = driver_->add_start(settings_, info_, steps_); !status.ok()) {
    close();
    return status;
  }
  next_step_ = 0;
  step_after_us_ = now_us();
  has_stalled_ = false;
  failures_in_a_row_ = 0;
  samples_.restart(*driver_, info_, settings_);
  counts_.phase = UsbCameraPhase::kStarting;
  published_.publish(counts_);
  return {};
}

Delivery UsbCameraSource::poll(Inlets& inlets, std::int64_t timeout_us) noexcept {
  Delivery done;
  switch (counts_.phase) {
    case UsbCameraPhase::kClosed:
      done = look_again(timeout_us);
      break;
    case UsbCameraPhase::kStarting:
      done = run_steps(inlets, timeout_us);
      break;
    case UsbCameraPhase::kStreaming:
      done = stream(inlets, timeout_us);
      break;
  }
  counts_.evt = samples_.evt();
  counts_.inivation = samples_.inivation();
  published_.publish(counts_);
  return done;
}

// Step after step; a wait that is longer than this poll may take goes on in the next one.
Delivery UsbCameraSource::run_steps(Inlets& inlets, std::int64_t timeout_us) noexcept {
  const std::span<const UsbStep> steps = steps_.items();
  const std::int64_t until_us = now_us() + timeout_us;
  do {
    const std::int64_t wait_until_us = lower_of(step_after_us_, until_us);
    if (transfers_.active() > 0) {
      const std::int64_t left_us = wait_until_us - now_us();
      if (const int error = service(inlets, left_us > 0 ? left_us : 0); error != 0)
        return lose(error, "while it was started");
    } else if (now_us() < wait_until_us) {
      clock_.sleep_until_us(clock_.self, wait_until_us);
    }
    if (now_us() < step_after_us_) continue;
    const UsbStep& step = steps[next_step_];
    if (const int error = run(step); error != 0) return lose(error, "while it was started");
    step_after_us_ = now_us() + step.wait_us;
    if (++next_step_ == steps.size()) {
      counts_.phase = UsbCameraPhase::kStreaming;
      last_data_us_ = drops_read_us_ = now_us();
      return delivery();
    }
  } while (now_us() < until_us);
  return delivery();
}

int UsbCameraSource::run(const UsbStep& step) noexcept {
  switch (step.kind) {
    case UsbStepKind::kWrite:
      return driver_->write(usb_, step.address, step.value);
    case UsbStepKind::kPulse:
      return driver_->pulse(usb_, step.address);
    case UsbStepKind::kTransfers:
      return send_transfers();
    case UsbStepKind::kSet:
    case UsbStepKind::kOffset:
      break;
  }
  std::uint32_t old = 0;
  if (const int error = driver_->read(usb_, step.address, old); error != 0) return error;
  if (step.kind == UsbStepKind::kSet)
    return driver_->write(usb_, step.address, (old & ~step.mask) | (step.value & step.mask));
  std::int64_t low = (old & 0xff) + static_cast<std::int64_t>(static_cast<std::int32_t>(step.value));
  low = low < 0 ? 0 : lower_of(low, 255);
  return driver_->write(usb_, step.address, (old & ~0xffu) | static_cast<std::uint32_t>(low));
}

int UsbCameraSource::send_transfers() noexcept {
  constexpr int kMostOldReads = 32;
  constexpr unsigned kOldRead_ms = 20;
  constexpr std::size_t kMostOldBytes = 128 * 1024;
  const std::span<std::byte> old =
      buffers_.first(buffers_.size() < kMostOldBytes ? buffers_.size() : kMostOldBytes);
  if (const int error = usb_.clear_halt(driver_->endpoint); error != 0) return error;
  for (int i = 0; driver_->is_drained && i < kMostOldReads; ++i) {
    std::size_t old_bytes = 0;
    const int error = usb_.bulk(driver_->endpoint, old, old_bytes, kOldRead_ms);
    if (error == ETIMEDOUT && old_bytes == 0) break;
    if (error != 0 && error != ETIMEDOUT) return error;
  }
  return transfers_.submit_all(usb_, driver_->endpoint, driver_->transfer_timeout_ms);
}

Delivery UsbCameraSource::stream(Inlets& inlets, std::int64_t timeout_us) noexcept {
  if (const int error = service(inlets, timeout_us); error != 0) return lose(error, "while it was streaming");
  const std::int64_t at_us = now_us();
  if (at_us - last_data_us_ > kSilence_us) return lose(ETIMEDOUT, "it sends nothing");
  read_dropped(at_us);
  return delivery();
}

// Waits for the oldest transfer, then takes all that have ended. Each is sent again at once, so the loop
// ends: nothing ends outside wait() but what the camera was asked for before.
int UsbCameraSource::service(Inlets& inlets, std::int64_t timeout_us) noexcept {
  if (transfers_.oldest_ended() == nullptr) {
    const int error = usb_.wait(timeout_us);
    if (error != 0 && error != EINTR) return error;
  }
  const std::int64_t at_us = now_us();
  for (std::size_t i = transfers_.active(); i > 0; --i) {
    UsbTransfer* const transfer = transfers_.oldest_ended();
    if (transfer == nullptr) break;
    if (const int error = take(*transfer, at_us, inlets); error != 0) return error;
  }
  return has_stalled_ && transfers_.active() == 0 ? restart_stalled() : 0;
}

// Data of a transfer count whatever its end was. Returns the errno that ends the stream.
int UsbCameraSource::take(UsbTransfer& transfer, std::int64_t at_us, Inlets& inlets) noexcept {
  ++counts_.transfers;
  counts_.bytes += transfer.length;
  if (transfer.length > 0) {
    last_data_us_ = at_us;
    retry_.worked();
    const bool is_live = counts_.phase == UsbCameraPhase::kStreaming;
    samples_.take(transfer.buffer.first(transfer.length), at_us, is_live, inlets, counts_);
  }
  switch (transfer.error) {
    case 0:
    case ETIMEDOUT:
      counts_.timed_out += transfer.error != 0;
      failures_in_a_row_ = 0;
      break;
    case ENODEV:
      return ENODEV;
    case EPIPE:
      // The others that are under way end first; then the halt is cleared and all begin anew.
      if (!has_stalled_) {
        ++counts_.stalls;
        ++failures_in_a_row_;
        has_stalled_ = true;
        transfers_.cancel(usb_);
      }
      break;
    case ECANCELED:
      break;
    case EOVERFLOW:
      ++counts_.overflows;
      ++failures_in_a_row_;
      break;
    default:
      ++counts_.failed;
      ++failures_in_a_row_;
  }
  if (failures_in_a_row_ >= kMostFailures) return transfer.error;
  if (has_stalled_) {
    transfers_.retire();
    return 0;
  }
  return transfers_.resubmit(usb_, driver_->endpoint, driver_->transfer_timeout_ms);
}

int UsbCameraSource::restart_stalled() noexcept {
  has_stalled_ = false;
  if (const int error = usb_.clear_halt(driver_->endpoint); error != 0) return error;
  return transfers_.submit_all(usb_, driver_->endpoint, driver_->transfer_timeout_ms);
}

// A refusal is no loss of the camera: its stream goes on.
void UsbCameraSource::read_dropped(std::int64_t at_us) noexcept {
  if (driver_->read_dropped == nullptr || !info_.has_statistics || at_us - drops_read_us_ < kDropsEvery_us)
    return;
  drops_read_us_ = at_us;
  std::uint64_t dropped = 0;
  if (driver_->read_dropped(usb_, dropped) == 0) counts_.device_dropped = dropped;
}

Delivery UsbCameraSource::lose(int error, const char* subject) noexcept {
  ++counts_.lost;
  counts_.last_error = {StatusCode::kDeviceLost, subject, error};
  close();
  retry_.failed(now_us());
  return delivery();
}

Delivery UsbCameraSource::look_again(std::int64_t timeout_us) noexcept {
  if (!was_started_)
    return {.watermark_us = samples_.watermark_us(),
            .ended = false,
            .status = {StatusCode::kBadState, "poll() of a USB camera before start()"}};
  if (!settings_.reopen) return delivery();
  const std::int64_t at_us = now_us();
  if (at_us < retry_.next_us()) {
    clock_.sleep_until_us(clock_.self, lower_of(retry_.next_us(), at_us + timeout_us));
    return delivery();
  }
  if (const Status status = start(); !status.ok()) {
    ++counts_.refused;
    counts_.last_error = status;
    retry_.failed(now_us());
  }
  return delivery();
}

Delivery UsbCameraSource::delivery() noexcept {
  Delivery told{.watermark_us = samples_.watermark_us(), .ended = false, .status = {}};
  if (counts_.phase == UsbCameraPhase::kClosed && !settings_.reopen) told.status = counts_.last_error;
  return told;
}

void UsbCameraSource::stop() noexcept {
  if (counts_.phase != UsbCameraPhase::kClosed) {
    steps_.clear();
    driver_->add_stop(steps_);
    for (const UsbStep& step : steps_.items()) {
      if (run(step) != 0) break;  // what does not answer is not asked a second time
      if (step.wait_us > 0) clock_.sleep_until_us(clock_.self, now_us() + step.wait_us);
    }
  }
  was_started_ = false;
  close();
  published_.publish(counts_);
}

// Transfers belong to the kernel until they have ended; the device is closed before their memory is given
// back, so that those which never end (a kernel that hangs) cannot come back later either.
void UsbCameraSource::close() noexcept {
  if (usb_.is_open()) {
    transfers_.cancel(usb_);
    for (int i = 0; i < kCancelWaits && transfers_.any_in_flight(); ++i) {
      static_cast<void>(usb_.wait(kCancelWait_us));
    }
  }
  usb_.close_device();
  transfers_.release(usb_);
  usb_.close();
  counts_.phase = UsbCameraPhase::kClosed;
}

UsbCameraCounters UsbCameraSource::counters() const noexcept {
  UsbCameraCounters counters;
  static_cast<void>(published_.read(counters));
  return counters;
}

}  // namespace egofocus
