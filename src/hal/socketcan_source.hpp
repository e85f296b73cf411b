// A CAN bus of this machine as a source of motion samples (Linux SocketCAN).
//
// Source: Documentation/networking/can.rst, Documentation/networking/timestamping.rst.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/snapshot.hpp"
#include "egofocus/source.hpp"
#include "hal/can_error.hpp"
#include "hal/can_motion_decoder.hpp"
#include "hal/clock_map.hpp"
#include "hal/socketcan_batch.hpp"
#include "hal/socketcan_io.hpp"

namespace egofocus {

struct SocketCanConfig {
  char interface_name[16] = "can0";
  /// The controller's own time stamps, where it has them, mapped onto the host's clock; else the kernel's.
  bool hardware_time = true;
  /// Samples keep the controller's time, for ClockKind::kDevice; frames without it are dropped.
  bool device_time = false;
  /// An interface that is not there at start() is waited for, as one that vanishes later is.
  bool wait_for_interface = false;
  /// 0: a bus-off node stays off until the kernel (`ip link set can0 type can restart-ms 100`) or somebody
  /// else restarts it. Else: it is set down and up again after this time, which every driver understands and
  /// which needs CAP_NET_ADMIN. gs_usb has neither restart-ms nor `restart`: there it is this or nothing.
  std::int64_t restart_after_us = 0;
  std::int32_t receive_buffer_bytes = 0;  ///< SO_RCVBUF; 0: the system's
};

enum class CanLink : std::uint8_t {
  kClosed,  ///< not started
  kUp,
  kDown,  ///< the interface is there, but down
  kGone,  ///< no interface of that name: unplugged, or its driver not loaded
};

/// "closed", "up", "down", "gone". Thread: any. RT: yes.
const char* to_string(CanLink link) noexcept;

/// All that came over the socket, and what became of it. Every message is in one of `frames`,
/// `remote_frames`, `errors.frames`, `malformed`.
struct SocketCanHealth {
  CanLink link = CanLink::kClosed;
  CanBusState bus = CanBusState::kActive;
  std::int32_t last_errno = 0;  ///< of the last call that failed in a way not named below
  std::uint64_t frames = 0;
  std::uint64_t remote_frames = 0;
  std::uint64_t malformed = 0;
  std::uint64_t kernel_dropped = 0;  ///< the socket's queue was full: this thread came too late
  /// No time stamp of the kernel, or one that cannot be: time of reading taken. device_time: none of the
  /// controller, dropped.
  std::uint64_t without_stamp = 0;
  std::uint64_t hardware_stamps = 0;
  std::uint64_t link_downs = 0;
  std::uint64_t link_losses = 0;
  std::uint64_t opened = 0;
  std::uint64_t restarts = 0;          ///< bus-off ended by restart_after_us
  std::uint64_t restarts_refused = 0;  ///< no CAP_NET_ADMIN
  std::uint64_t failed_calls = 0;
  CanErrorCounters errors;
  CanMotionCounters motion;
  ClockMapCounters clock;
  double clock_drift_ppm = 0;
};

/// A full backend. What happens to interface and bus after start() is no end of it: it is counted, told by
/// health(), and waited out, without spinning. Samples are stamped when their frame ended on the bus, within
/// what the kernel (interrupt latency) or the controller knows.
///
/// Thread: start, poll and stop: one at a time, poll's is the writer of imu and odometry; health: any.
/// RT: poll yes: waits at most `timeout_us`, reads at most 256 frames; while an interface is being waited
/// for, a few system calls each 100 ms.
class SocketCanSource {
 public:
  /// `motion` is configured and outlives the source; only frames that it uses pass the kernel's filter. `tap`
  /// sees these.
  SocketCanSource(const SocketCanConfig& config, CanMotionDecoder& motion, CanTap tap = {},
                  const SocketCanIo& io = system_socketcan_io()) noexcept
      : config_(config), motion_(&motion), tap_(tap), io_(io) {}
  ~SocketCanSource() { stop(); }
  SocketCanSource(const SocketCanSource&) = delete;
  SocketCanSource& operator=(const SocketCanSource&) = delete;

  /// The four functions over this object, which must outlive the copy.
  Source source() noexcept;

  /// kIo with errno; the subject says what was refused. Nothing is left open then.
  Status start() noexcept;
  Delivery poll(Inlets& inlets, std::int64_t timeout_us) noexcept;
  void stop() noexcept;

  /// False when the source's thread interfered too often (then unchanged).
  bool health(SocketCanHealth& out) const noexcept { return published_.read(out); }

 private:
  Status open() noexcept;
  Status prepare(int fd) noexcept;
  void lose(CanLink link) noexcept;
  void watch_link(std::int64_t now_us) noexcept;
  void watch_bus(std::int64_t now_us) noexcept;
  void raise_link() noexcept;
  void receive(Inlets& inlets) noexcept;
  bool failed(int code) noexcept;
  void take(const CanMessage& message, Inlets& inlets) noexcept;
  void take_time(const CanMessage& message, CanFrame& frame) noexcept;
  bool take_device_time(const CanMessage& message, CanFrame& frame) noexcept;
  void sample_clocks() noexcept;
  void publish() noexcept;
  [[nodiscard]] std::int64_t now_us() const noexcept { return io_.now_ns(io_.self, false) / 1000; }

  SocketCanConfig config_;
  CanMotionDecoder* motion_;
  CanTap tap_;
  SocketCanIo io_;
  int fd_ = -1;
  int index_ = 0;
  std::int64_t next_look_us_ = 0;      // at the interface, while it is down or gone
  std::int64_t bus_off_since_us_ = 0;  // 0: it is not
  bool owes_up_ = false;               // this object has set the interface down
  std::int64_t read_ns_ = 0;           // monotonic time of the last reading
  std::int64_t monotonic_minus_real_ns_ = 0;
  std::uint32_t last_drops_ = 0;
  SocketCanBatch batch_;
  CanErrorDecoder errors_;
  ClockMap clock_;
  std::int64_t device_watermark_us_ = INT64_MIN;  // device_time: all up to here was taken
  SocketCanHealth health_;
  Snapshot<SocketCanHealth> published_;
};

}  // namespace egofocus
