// Events -> the words that an iniVation camera would send, from their layouts alone.
#pragma once

#include <cstdint>

#include "egofocus/types.hpp"
#include "hal/inivation_stream.hpp"

namespace egofocus::reliability {

/// Time stamps of 15 bits with their wraps, then the event as the camera's kind has it. Times must not fall.
class InivationWriter {
 public:
  enum class Camera : std::uint8_t { kDavis, kDvxplorer };
  explicit InivationWriter(Camera camera) noexcept : camera_(camera) {}

  /// The camera's clock begins anew.
  void reset(inivation::Bytes& out) {
    wraps_ = 0;
    low_ = -1;
    word(out, inivation::time_reset());
  }

  void time(inivation::Bytes& out, std::int64_t device_us) {
    constexpr std::int64_t kMostWraps = 0xfff;
    for (std::int64_t due = (device_us >> 15) - wraps_; due > 0; due = (device_us >> 15) - wraps_) {
      const std::int64_t some = due < kMostWraps ? due : kMostWraps;
      word(out, inivation::wrap(static_cast<std::uint32_t>(some)));
      wraps_ += some;
      low_ = -1;
    }
    if (low_ == (device_us & 0x7fff)) return;
    low_ = device_us & 0x7fff;
    word(out, inivation::time_stamp(static_cast<std::uint32_t>(low_)));
  }

  void event(inivation::Bytes& out, std::int64_t device_us, const Event& event) {
    time(out, device_us);
    if (camera_ == Camera::kDavis) {
      word(out, inivation::row(event.y));
      word(out, inivation::column(event.polarity, event.x));
    } else {
      word(out, inivation::dvx_column(event.x));
      word(out, inivation::dvx_rows(event.y / 8u, 0, false));
      word(out, inivation::dvx_group(1, event.polarity, 1u << (event.y % 8u)));
    }
  }

 private:
  static void word(inivation::Bytes& out, inivation::Word word) { evt_words::append(out, word, 2); }

  Camera camera_;
  std::int64_t wraps_ = 0;
  std::int64_t low_ = -1;
};

}  // namespace egofocus::reliability
