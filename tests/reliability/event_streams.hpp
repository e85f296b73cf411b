// The same events through every camera format's real decoder, for as long as one likes: five streams that go
// on for ever, whose time stamps wrap as the cameras' do.
#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "hal/evt21_decoder.hpp"
#include "hal/evt21_encoder.hpp"
#include "hal/evt2_decoder.hpp"
#include "hal/evt2_encoder.hpp"
#include "hal/evt3_decoder.hpp"
#include "hal/evt3_encoder.hpp"
#include "hal/inivation_decoder.hpp"
#include "inivation_writer.hpp"

namespace egofocus::reliability {

/// Prophesee: what an encoder writes.
template <typename Encoder, typename Decoder>
class EvtStream {
 public:
  EvtStream(Encoder encoder, Decoder decoder) : encoder_(encoder), decoder_(decoder) {}

  /// What comes out of the decoder for these events. Valid until the next call.
  std::span<const Event> pass(std::span<const Event> events) {
    out_.clear();
    while (!events.empty()) {
      const Decoded written = encoder_.encode(events, bytes_);
      events = events.subspan(written.consumed);
      for (std::span<const std::byte> left = std::span(bytes_).first(written.produced); !left.empty();) {
        const Decoded read = decoder_.feed(left, some_);
        left = left.subspan(read.consumed);
        out_.insert(out_.end(), some_.begin(), some_.begin() + static_cast<std::ptrdiff_t>(read.produced));
      }
    }
    return out_;
  }
  [[nodiscard]] std::uint64_t violations() const {
    std::uint64_t all = decoder_.counters().dropped_events;
    for (const std::uint64_t kind : decoder_.counters().violations) all += kind;
    return all;
  }

 private:
  Encoder encoder_;
  Decoder decoder_;
  std::vector<std::byte> bytes_ = std::vector<std::byte>(1 << 12);
  std::vector<Event> some_ = std::vector<Event>(256);
  std::vector<Event> out_;
};

/// iniVation: USB packets of whole words.
class InivationStream {
 public:
  InivationStream(InivationFormat format, SensorSize size)
      : writer_(format == InivationFormat::kDavis ? InivationWriter::Camera::kDavis
                                                  : InivationWriter::Camera::kDvxplorer),
        decoder_({.format = format, .sent = size}) {}

  std::span<const Event> pass(std::span<const Event> events) {
    out_.clear();
    bytes_.clear();
    for (const Event& event : events) writer_.event(bytes_, event.t_us, event);
    for (std::span<const std::byte> left = bytes_; !left.empty();) {
      const InivationDecoded read = decoder_.feed(left, some_, imu_);
      left = left.subspan(read.consumed);
      out_.insert(out_.end(), some_.begin(), some_.begin() + static_cast<std::ptrdiff_t>(read.events));
    }
    decoder_.end_transfer();
    return out_;
  }
  [[nodiscard]] std::uint64_t violations() const {
    std::uint64_t all = decoder_.counters().dropped_events;
    for (const std::uint64_t kind : decoder_.counters().violations) all += kind;
    return all;
  }

 private:
  InivationWriter writer_;
  InivationDecoder decoder_;
  inivation::Bytes bytes_;
  std::vector<Event> some_ = std::vector<Event>(256);
  std::vector<ImuSample> imu_ = std::vector<ImuSample>(4);
  std::vector<Event> out_;
};

/// All of them, by number.
class EventStreams {
  template <typename Use>
  decltype(auto) with(int format, Use use) {
    switch (format) {
      case 0:
        return use(evt2_);
      case 1:
        return use(evt21_);
      case 2:
        return use(evt3_);
      case 3:
        return use(davis_);
      default:
        return use(dvxplorer_);
    }
  }

 public:
  static constexpr int kCount = 5;
  struct Format {
    const char* name;
    int wrap_bits;  ///< device time on the wire begins anew after 2^wrap_bits us
  };
  static constexpr std::array<Format, kCount> kFormats{
      {{"EVT2", 34}, {"EVT2.1", 34}, {"EVT3", 24}, {"DAVIS", 15}, {"DVXplorer", 15}}};

  explicit EventStreams(SensorSize size)
      : evt2_({}, Evt2Decoder(size)),
        evt21_(Evt21Encoder(Evt21Order::kLittleEndian), {size, Evt21Order::kLittleEndian}),
        evt3_({}, Evt3Decoder(size)),
        davis_(InivationFormat::kDavis, size),
        dvxplorer_(InivationFormat::kDvxplorer, size) {}

  std::span<const Event> pass(int format, std::span<const Event> events) {
    return with(format, [&](auto& stream) { return stream.pass(events); });
  }
  [[nodiscard]] std::uint64_t violations(int format) {
    return with(format, [](auto& stream) { return stream.violations(); });
  }

 private:
  EvtStream<Evt2Encoder, Evt2Decoder> evt2_;
  EvtStream<Evt21Encoder, Evt21Decoder> evt21_;
  EvtStream<Evt3Encoder, Evt3Decoder> evt3_;
  InivationStream davis_;
  InivationStream dvxplorer_;
};

inline bool same(std::span<const Event> a, std::span<const Event> b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Event& x, const Event& y) {
    return x.t_us == y.t_us && x.x == y.x && x.y == y.y && x.polarity == y.polarity;
  });
}

}  // namespace egofocus::reliability
