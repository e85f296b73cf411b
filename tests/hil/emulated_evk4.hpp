// A Prophesee EVK4 with an IMX636: Treuzell requests, registers, EVT3.
#pragma once

#include <cstdint>
#include <deque>
#include <map>

#include "hil/camera_time.hpp"
#include "hil/emulated_usb.hpp"
#include "hil/event_feed.hpp"

namespace egofocus::hil {

/// Streams while bit 10 of register 0004 is set: the feed's events, in packets of 1 ms. Source: OpenEB,
/// hal_psee_plugins/src/boards/treuzell and src/devices/imx636.
class EmulatedEvk4 : public EmulatedUsb {
 public:
  static constexpr int kWidth_px = 1280;
  static constexpr int kHeight_px = 720;

  /// `feed` outlives the camera.
  explicit EmulatedEvk4(EventFeed& feed);
  ~EmulatedEvk4() override { unplug(); }

  [[nodiscard]] CameraTime& time() { return time_; }

 protected:
  bool control(const Setup&, Bytes&) override { return false; }
  void out(std::uint8_t endpoint, const Bytes& data) override;
  int in(std::uint8_t endpoint, std::size_t most, Bytes& data) override;

 private:
  void answer(std::uint32_t property, const Bytes& request, Bytes& payload, bool& is_known);
  void write(std::uint32_t address, std::uint32_t value);

  EventFeed& feed_;
  CameraTime time_;
  std::map<std::uint32_t, std::uint32_t> registers_;
  std::deque<Bytes> answers_;
};

}  // namespace egofocus::hil
