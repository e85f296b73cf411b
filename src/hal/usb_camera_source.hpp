// A live event camera on USB as a source: found, started, streamed, lost, found again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/clock.hpp"
#include "core/snapshot.hpp"
#include "egofocus/source.hpp"
#include "hal/retry_pause.hpp"
#include "hal/usb_camera.hpp"
#include "hal/usb_camera_counters.hpp"
#include "hal/usb_camera_samples.hpp"
#include "hal/usb_transfers.hpp"

namespace egofocus {

/// The range that every setting must lie in, whatever camera there is. kBadDeviceSetting. Thread: any. RT:
/// yes.
Status check_usb_settings(const UsbCameraSettings& settings) noexcept;

/// One camera. open() finds and identifies it; start() begins its start sequence, whose waits (DAVIS 0.3 s,
/// IMX636 2.6 s) poll() works off without waiting longer than it may; then poll() streams. A camera that is
/// unplugged, silent for a second or failing without end is closed with all that belongs to it, and with
/// settings.reopen looked for again after 0.1 s, 0.2 s, ... 2 s, by its serial number. Looking for it takes
/// as long as the bus takes to answer: that poll may be late.
///
/// Ours allocates nothing after open(); libusb does, for each transfer that is sent. Events and IMU samples
/// keep the device's order; times are the host's (ClockMap).
/// Thread: one calls open .. stop and writes the event inlet (and the IMU inlet with settings.imu);
/// counters() from any. RT: poll yes but for libusb's own and for re-opening.
class UsbCameraSource {
 public:
  /// Bytes for `buffers`, enough for any family with these settings. Thread: any. RT: yes.
  static std::size_t buffer_bytes(const UsbCameraSettings& settings) noexcept;

  /// `buffers` and what `io` points to outlive the source.
  UsbCameraSource(const UsbCameraSettings& settings, std::span<std::byte> buffers, const UsbIo& io,
                  Clock clock) noexcept
      : settings_(settings), buffers_(buffers), io_(io), clock_(clock) {}
  ~UsbCameraSource() { stop(); }
  UsbCameraSource(const UsbCameraSource&) = delete;
  UsbCameraSource& operator=(const UsbCameraSource&) = delete;

  /// The functions over this object, which must outlive the copy.
  Source source() noexcept;

  /// kArenaTooSmall (buffers), kBadDeviceSetting, kNoDevice, kAmbiguousDevice, kNoPermission, kDeviceBusy,
  /// kUnknownFirmware, kUnsupportedDevice, kDeviceLost, kIo. On failure all is closed. RT: no.
  Status open() noexcept;
  /// Opens when that has not been done. Errors: those of open(). RT: no.
  Status start() noexcept;
  /// See Source. Live: what is there is pushed whatever its time. Without settings.reopen a loss is the
  /// status kDeviceLost.
  Delivery poll(Inlets& inlets, std::int64_t timeout_us) noexcept;
  /// Stops and closes: at most 1 s for each of a request and the transfers that do not come back. RT: no.
  void stop() noexcept;

  /// After open().
  [[nodiscard]] const UsbCameraInfo& info() const noexcept { return info_; }
  /// Newest complete snapshot; untouched counters before the first poll.
  [[nodiscard]] UsbCameraCounters counters() const noexcept;

 private:
  Status find() noexcept;
  Status open_matching(std::span<const UsbDevice> candidates) noexcept;
  [[nodiscard]] std::int64_t now_us() const noexcept { return clock_.now_us(clock_.self); }

  Delivery run_steps(Inlets& inlets, std::int64_t timeout_us) noexcept;
  int run(const UsbStep& step) noexcept;
  int send_transfers() noexcept;
  Delivery stream(Inlets& inlets, std::int64_t timeout_us) noexcept;
  int service(Inlets& inlets, std::int64_t timeout_us) noexcept;
  int take(UsbTransfer& transfer, std::int64_t at_us, Inlets& inlets) noexcept;
  int restart_stalled() noexcept;
  void read_dropped(std::int64_t at_us) noexcept;
  Delivery lose(int error, const char* subject) noexcept;
  Delivery look_again(std::int64_t timeout_us) noexcept;
  void close() noexcept;
  [[nodiscard]] Delivery delivery() noexcept;

  UsbCameraSettings settings_;
  std::span<std::byte> buffers_;
  const UsbIo& io_;
  Clock clock_;

  UsbConnection usb_;
  UsbTransfers transfers_;
  const UsbCameraDriver* driver_ = nullptr;
  UsbCameraInfo info_;
  char known_serial_[sizeof UsbCameraInfo::serial] = {};  // of the first camera: no other one takes its place
  UsbSteps steps_;
  std::size_t next_step_ = 0;
  std::int64_t step_after_us_ = 0;
  UsbCameraSamples samples_;
  UsbCameraCounters counts_;  // the polling thread's own
  Snapshot<UsbCameraCounters> published_;
  bool was_started_ = false;
  bool has_stalled_ = false;
  int failures_in_a_row_ = 0;
  std::int64_t last_data_us_ = 0;
  std::int64_t drops_read_us_ = 0;
  RetryPause retry_;
};

}  // namespace egofocus
