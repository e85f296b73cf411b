#include "hal/socketcan_source.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/net_tstamp.h>

#include <cerrno>

namespace egofocus {
namespace {

constexpr std::int64_t kLookUs = 100000;  // between two looks for an interface
constexpr int kBatches = 8;               // of one poll
constexpr int kClockTries = 3;
constexpr std::int64_t kTightNs = 20000;
constexpr std::int64_t kOldestStampNs = 10'000'000'000;

std::int64_t lower_of(std::int64_t a, std::int64_t b) noexcept {
  return a < b ? a : b;
}

// What to do about an errno of open().
const char* reason_of(int code) noexcept {
  switch (code) {
    case -ENODEV:
      return "CAN interface: there is none of that name (see `ip link`; adapter plugged in, driver loaded?)";
    case -EAFNOSUPPORT:
    case -EPROTONOSUPPORT:
    case -ESOCKTNOSUPPORT:
      return "this kernel has no CAN sockets: `modprobe can-raw`, or a kernel with CONFIG_CAN_RAW";
    case -EPERM:
    case -EACCES:
      return "CAN socket: not permitted";
    default:
      return "CAN socket";
  }
}

}  // namespace

const char* to_string(CanLink link) noexcept {
  switch (link) {
    case CanLink::kClosed:
      return "closed";
    case CanLink::kUp:
      return "up";
    case CanLink::kDown:
      return "down";
    case CanLink::kGone:
      return "gone";
  }
  return "unknown";
}

Source SocketCanSource::source() noexcept {
  return {.self = this,
          .name = "socketcan",
          .start = [](void* self) noexcept { return static_cast<SocketCanSource*>(self)->start(); },
          .poll =
              [](void* self, Inlets& inlets, std::int64_t, std::int64_t timeout_us) noexcept {
                return static_cast<SocketCanSource*>(self)->poll(inlets, timeout_us);
              },
          .stop = [](void* self) noexcept { static_cast<SocketCanSource*>(self)->stop(); }};
}

Status SocketCanSource::start() noexcept {
  stop();
  health_ = {};
  errors_ = {};
  clock_ = {};
  device_watermark_us_ = INT64_MIN;
  bus_off_since_us_ = 0;
  const Status status = open();
  const bool absent = status.value() == ENODEV;
  if (!status.ok() && !(absent && config_.wait_for_interface)) {
    health_.link = CanLink::kClosed;
    return status;
  }
  publish();
  return {};
}

void SocketCanSource::stop() noexcept {
  if (fd_ >= 0) io_.close(io_.self, fd_);
  fd_ = -1;
  health_.link = CanLink::kClosed;
  publish();
}

Status SocketCanSource::open() noexcept {
  health_.link = CanLink::kGone;
  next_look_us_ = now_us() + kLookUs;
  const int fd = io_.open(io_.self);
  if (fd < 0) return {StatusCode::kIo, reason_of(fd), -fd};
  if (const Status status = prepare(fd); !status.ok()) {
    io_.close(io_.self, fd);
    return status;
  }
  fd_ = fd;
  last_drops_ = 0;
  clock_.reset();
  errors_.restart();
  bus_off_since_us_ = 0;
  owes_up_ = false;
  ++health_.opened;
  sample_clocks();
  health_.link = io_.is_up(io_.self, fd, config_.interface_name) == 1 ? CanLink::kUp : CanLink::kDown;
  return {};
}

// Filters come before bind(), so that nothing else ever queues up.
Status SocketCanSource::prepare(int fd) noexcept {
  const auto set = [this, fd](int level, int option, const auto& value) noexcept {
    return io_.set_option(io_.self, fd, level, option, &value, sizeof value);
  };
  CanFilter filters[CanMotionConfig::kMaxSignals];
  can_filter kernel_filters[CanMotionConfig::kMaxSignals];
  const std::size_t count = motion_->filters(filters);
  for (std::size_t i = 0; i < count; ++i) {
    const canid_t kind = filters[i].extended ? CAN_EFF_FLAG : 0;
    kernel_filters[i] = {filters[i].id | kind, filters[i].mask | CAN_EFF_FLAG | CAN_RTR_FLAG};
  }
  int code = io_.set_option(io_.self, fd, SOL_CAN_RAW, CAN_RAW_FILTER, kernel_filters,
                            static_cast<socklen_t>(count * sizeof(can_filter)));
  if (code < 0) return {StatusCode::kIo, "CAN filters", -code};

  // A kernel that lacks one of these tells less, but works.
  const int on = 1;
  const can_err_mask_t all_errors = CAN_ERR_MASK;
  const int stamps = SOF_TIMESTAMPING_RX_SOFTWARE | SOF_TIMESTAMPING_SOFTWARE |
                     (config_.hardware_time || config_.device_time
                          ? SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE
                          : 0);
  for (const int done :
       {set(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, on), set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, all_errors),
        set(SOL_SOCKET, SO_TIMESTAMPING, stamps), set(SOL_SOCKET, SO_RXQ_OVFL, on)}) {
    if (done < 0) failed(done);
  }
  if (config_.receive_buffer_bytes > 0) {
    code = set(SOL_SOCKET, SO_RCVBUF, config_.receive_buffer_bytes);
    if (code < 0) return {StatusCode::kIo, "CAN receive buffer", -code};
  }

  index_ = io_.index_of(io_.self, fd, config_.interface_name);
  if (index_ < 0) return {StatusCode::kIo, reason_of(index_), -index_};
  code = io_.bind(io_.self, fd, index_);
  if (code == -ENODEV) return {StatusCode::kIo, "CAN interface: the one of that name is no CAN bus", ENODEV};
  if (code < 0) return {StatusCode::kIo, reason_of(code), -code};
  return {};
}

Delivery SocketCanSource::poll(Inlets& inlets, std::int64_t timeout_us) noexcept {
  std::int64_t wait_us = timeout_us;
  if (health_.link != CanLink::kUp) wait_us = lower_of(wait_us, kLookUs);
  const int came = io_.wait(io_.self, fd_, wait_us);
  if (came > 0) receive(inlets);
  if (came < 0 && came != -EINTR && failed(came)) lose(CanLink::kGone);
  const std::int64_t now = now_us();
  if (health_.link != CanLink::kUp) watch_link(now);
  watch_bus(now);
  publish();
  const std::int64_t host_watermark_us = now - can_lag_us(motion_->config());
  return {.watermark_us = config_.device_time ? device_watermark_us_ : host_watermark_us,
          .ended = false,
          .status = {}};
}

void SocketCanSource::receive(Inlets& inlets) noexcept {
  for (int i = 0; i < kBatches && fd_ >= 0; ++i) {
    const int count = io_.receive(io_.self, fd_, batch_.prepare(), SocketCanBatch::kMessages);
    if (count == -EINTR) continue;
    if (count == -ENETDOWN) return lose(CanLink::kDown);
    if (count < 0) {
      if (failed(count)) lose(CanLink::kGone);
      return;
    }
    sample_clocks();
    for (unsigned k = 0; k < static_cast<unsigned>(count); ++k) take(batch_.message(k), inlets);
    if (count < static_cast<int>(SocketCanBatch::kMessages)) return;
  }
}

// Whether the socket is of no more use.
bool SocketCanSource::failed(int code) noexcept {
  if (code == -EAGAIN || code == -EINTR) return false;
  if (code == -ENODEV || code == -ENXIO) return true;
  ++health_.failed_calls;
  health_.last_errno = -code;
  return code != -ENOBUFS && code != -ENOMEM && code != -ENOPROTOOPT;
}

// The socket outlives an interface that is set down, and hears it again; one that was removed takes its
// socket's binding along.
void SocketCanSource::lose(CanLink link) noexcept {
  next_look_us_ = now_us() + kLookUs;
  if (link == CanLink::kDown) {
    health_.link_downs += health_.link == CanLink::kUp;
  } else {
    health_.link_losses += health_.link != CanLink::kGone;
    if (fd_ >= 0) io_.close(io_.self, fd_);
    fd_ = -1;
  }
  health_.link = link;
}

void SocketCanSource::watch_link(std::int64_t now) noexcept {
  if (now < next_look_us_) return;
  next_look_us_ = now + kLookUs;
  if (fd_ < 0) {
    const Status status = open();
    if (!status.ok() && status.value() != ENODEV) failed(-static_cast<int>(status.value()));
    return;
  }
  // Removed and made anew under its name between two looks: another number.
  if (io_.index_of(io_.self, fd_, config_.interface_name) != index_) return lose(CanLink::kGone);
  if (owes_up_) raise_link();
  if (io_.is_up(io_.self, fd_, config_.interface_name) != 1) return;
  health_.link = CanLink::kUp;
  clock_.reset();  // controllers begin at 0 when they are set up
  errors_.restart();
  bus_off_since_us_ = 0;
}

void SocketCanSource::watch_bus(std::int64_t now) noexcept {
  if (errors_.state() != CanBusState::kOff || health_.link != CanLink::kUp) {
    bus_off_since_us_ = 0;
    return;
  }
  if (bus_off_since_us_ == 0) bus_off_since_us_ = now;
  if (config_.restart_after_us <= 0 || now - bus_off_since_us_ < config_.restart_after_us) return;
  bus_off_since_us_ = now;  // the next try, should this one not help
  const int code = io_.set_up(io_.self, fd_, config_.interface_name, false);
  if (code < 0) {
    ++health_.restarts_refused;
    health_.last_errno = -code;
    return;
  }
  owes_up_ = true;
  raise_link();
}

void SocketCanSource::raise_link() noexcept {
  const int code = io_.set_up(io_.self, fd_, config_.interface_name, true);
  owes_up_ = code < 0;
  if (code < 0) {
    health_.last_errno = -code;
  } else {
    ++health_.restarts;
    errors_.restart();
  }
}

void SocketCanSource::take(const CanMessage& message, Inlets& inlets) noexcept {
  if (message.has_drops) {
    health_.kernel_dropped += message.drops - last_drops_;
    last_drops_ = message.drops;
  }
  switch (message.kind) {
    case CanMessage::Kind::kMalformed:
      ++health_.malformed;
      return;
    case CanMessage::Kind::kRemote:
      ++health_.remote_frames;
      return;
    case CanMessage::Kind::kError:
      errors_.feed(message.frame.id, {message.frame.data, message.frame.length});
      return;
    case CanMessage::Kind::kData:
      break;
  }
  ++health_.frames;
  errors_.hear();
  CanFrame frame = message.frame;
  if (!config_.device_time) {
    take_time(message, frame);
  } else if (!take_device_time(message, frame)) {
    return;
  }
  if (tap_.frame != nullptr) tap_.frame(tap_.self, frame);
  MotionSamples samples;
  motion_->feed(frame, samples);
  if (samples.imu_count > 0) inlets.push(std::span<const ImuSample>(samples.imu, samples.imu_count));
  if (samples.odometry_count > 0)
    inlets.push(std::span<const OdometrySample>(samples.odometry, samples.odometry_count));
}

// The kernel turns stamping on a moment after it was asked to, so the first frames may lack theirs; and
// CLOCK_REALTIME may have been set between stamp and reading.
void SocketCanSource::take_time(const CanMessage& message, CanFrame& frame) noexcept {
  std::int64_t host_ns = message.software_ns + monotonic_minus_real_ns_;
  if (message.software_ns == 0 || host_ns > read_ns_ + kTightNs || host_ns < read_ns_ - kOldestStampNs) {
    ++health_.without_stamp;
    host_ns = read_ns_;
  }
  frame.t_us = lower_of(host_ns, read_ns_) / 1000;
  if (message.hardware_ns == 0 || !config_.hardware_time) return;
  ++health_.hardware_stamps;
  const std::int64_t device_us = message.hardware_ns / 1000;
  clock_.observe(device_us, frame.t_us);
  if (clock_.begun()) frame.t_us = lower_of(clock_.to_host_us(device_us), read_ns_ / 1000);
}

bool SocketCanSource::take_device_time(const CanMessage& message, CanFrame& frame) noexcept {
  health_.hardware_stamps += message.hardware_ns != 0;
  health_.without_stamp += message.hardware_ns == 0;
  if (message.hardware_ns == 0) return false;
  frame.t_us = message.hardware_ns / 1000;
  const std::int64_t all_us = frame.t_us - can_lag_us(motion_->config()) - 1;  // its microsecond may go on
  if (all_us > device_watermark_us_) device_watermark_us_ = all_us;
  return true;
}

// The offset between two clocks that run on: the tightest of a few brackets.
void SocketCanSource::sample_clocks() noexcept {
  std::int64_t tightest = INT64_MAX;
  for (int i = 0; i < kClockTries && tightest > kTightNs; ++i) {
    const std::int64_t before = io_.now_ns(io_.self, false);
    const std::int64_t real = io_.now_ns(io_.self, true);
    const std::int64_t after = io_.now_ns(io_.self, false);
    read_ns_ = after;
    if (after - before >= tightest) continue;
    tightest = after - before;
    monotonic_minus_real_ns_ = before + tightest / 2 - real;
  }
}

void SocketCanSource::publish() noexcept {
  health_.bus = errors_.state();
  health_.errors = errors_.counters();
  health_.motion = motion_->counters();
  health_.clock = clock_.counters();
  health_.clock_drift_ppm = clock_.drift_ppm();
  published_.publish(health_);
}

}  // namespace egofocus
