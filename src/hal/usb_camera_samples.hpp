// From the bytes of a camera to samples in the inlets, on the host's clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/source.hpp"
#include "hal/evt3_decoder.hpp"
#include "hal/inivation_decoder.hpp"
#include "hal/source_clock.hpp"
#include "hal/usb_camera.hpp"
#include "hal/usb_camera_counters.hpp"

namespace egofocus {

/// Decodes, maps device time to host time, pushes. Nothing is pushed before the clock map knows its first
/// pair, nor in a transfer in which device time was reset: such samples are counted as unmapped. Thread: one.
/// RT: take yes, O(bytes).
class UsbCameraSamples {
 public:
  /// A camera was opened: decoders and clock begin anew, counts go on.
  void restart(const UsbCameraDriver& driver, const UsbCameraInfo& info,
               const UsbCameraSettings& settings) noexcept;

  /// The bytes of one transfer that ended at `host_us`. `is_live` false: decoded and counted only.
  void take(std::span<const std::byte> bytes, std::int64_t host_us, bool is_live, Inlets& inlets,
            UsbCameraCounters& counters) noexcept;

  /// Every sample up to here has been pushed; INT64_MIN before the first.
  [[nodiscard]] std::int64_t watermark_us() const noexcept { return clock_.watermark_us(); }
  [[nodiscard]] const EvtCounters& evt() const noexcept { return evt_.counters(); }
  [[nodiscard]] const InivationCounters& inivation() const noexcept { return inivation_.counters(); }

 private:
  static constexpr std::size_t kStagedEvents = 1024;
  static constexpr std::size_t kStagedImu = 64;

  struct Batch {
    std::size_t consumed = 0;
    std::size_t events = 0;
    std::size_t imu = 0;
    bool is_last = false;
  };

  Batch decode(std::span<const std::byte> bytes) noexcept;
  [[nodiscard]] std::uint64_t time_jumps() const noexcept;
  void push(const Batch& batch, Inlets& inlets, UsbCameraCounters& counters) noexcept;

  bool is_inivation_ = false;
  bool wants_imu_ = false;
  AxisMap imu_axes_;
  InivationDecoder inivation_{InivationLayout{}};
  Evt3Decoder evt_{SensorSize{}};
  SourceClock clock_;
  std::array<Event, kStagedEvents> events_;
  std::array<ImuSample, kStagedImu> imu_;
};

}  // namespace egofocus
