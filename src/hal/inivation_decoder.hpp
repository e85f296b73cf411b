// DAVIS and DVXplorer (FPGA): 16-bit words of time, address, inertial bytes and marks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/types.hpp"
#include "hal/evt_words.hpp"
#include "hal/inivation_imu.hpp"
#include "hal/inivation_words.hpp"
#include "hal/sensor_size.hpp"

namespace egofocus {

/// How the camera's logic sends its addresses, read from the device.
struct InivationLayout {
  InivationFormat format = InivationFormat::kDavis;
  SensorSize sent;              ///< columns and rows as the words have them, before `swaps_xy`
  bool swaps_xy = false;        ///< orientation bit 2: x and y change places after decoding
  std::uint32_t imu_flips = 0;  ///< IMU parameter 1
  /// The size that events keep to.
  [[nodiscard]] SensorSize size() const noexcept {
    return swaps_xy ? SensorSize{sent.height_px, sent.width_px} : sent;
  }
};

/// As Decoded, with two kinds of samples.
struct InivationDecoded {
  std::size_t consumed = 0;
  std::size_t events = 0;
  std::size_t imu = 0;
};

/// Bytes in any cut -> events and IMU samples in raw device time (us), unwrapped to 64 bits. As long as there
/// is room in both spans, all input is taken. Events never go back in time: those under a time stamp that
/// does are dropped. Frames are skipped and counted. Sources: libcaer, src/davis.c, src/dvxplorer.c,
/// src/timestamps.h, as of firmware below 1.0. Thread: one. RT: yes, O(bytes).
class InivationDecoder {
 public:
  /// `so_far`: counts to go on from, of a decoder before this one.
  explicit InivationDecoder(const InivationLayout& layout, const InivationCounters& so_far = {}) noexcept
      : layout_(layout), imu_(layout.format, layout.imu_flips), counters_(so_far) {}

  /// Precondition: neither span is empty.
  InivationDecoded feed(std::span<const std::byte> bytes, std::span<Event> events,
                        std::span<ImuSample> imu) noexcept;
  /// A word never crosses USB transfers: half of one at the end of a transfer is dropped and counted.
  void end_transfer() noexcept;

  /// Newest device time; moves on without events, too, since the camera sends wraps all the time.
  [[nodiscard]] std::int64_t time_us() const noexcept { return time_.us(); }
  [[nodiscard]] bool is_time_known() const noexcept { return time_.is_known(); }
  [[nodiscard]] const InivationCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr std::uint16_t kNowhere = 0xffff;

  std::size_t take(std::uint16_t word, std::span<Event> events, ImuSample& sample, bool& has_sample) noexcept;
  void take_special(std::uint16_t data, ImuSample& sample, bool& has_sample) noexcept;
  void take_misc8(std::uint16_t data) noexcept;
  std::size_t take_davis(std::uint32_t code, std::uint16_t data, std::span<Event> room) noexcept;
  std::size_t take_dvxplorer(std::uint32_t code, std::uint16_t data, std::span<Event> room) noexcept;
  void take_row_groups(std::uint16_t data) noexcept;
  std::size_t place(std::uint16_t x, std::uint16_t y, std::uint32_t mask, std::uint8_t polarity,
                    std::span<Event> room) noexcept;
  std::size_t resume(std::span<Event> room) noexcept;

  InivationLayout layout_;
  WordReader<std::uint16_t> words_;
  InivationTime time_;
  InivationImu imu_;
  std::uint16_t x_ = kNowhere;         // DVXplorer
  std::uint16_t y_ = kNowhere;         // DAVIS; DVXplorer: of group 1
  std::uint16_t second_y_ = kNowhere;  // DVXplorer: of group 2
  Event held_;                         // as sent; bit i of held_mask_ is the pixel y + i
  std::uint32_t held_mask_ = 0;
  InivationCounters counters_;
};

}  // namespace egofocus
