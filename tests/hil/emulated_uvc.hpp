// An event sensor behind V4L2: the kernel's uvcvideo driver makes a video node of it. As on a Raspberry Pi 5
// the format is 8-bit grey, each buffer is full, and what lies behind the sensor's end-of-frame marker is
// left over from earlier frames.
#pragma once

#include <cstdint>

#include "hil/camera_time.hpp"
#include "hil/emulated_usb.hpp"
#include "hil/event_feed.hpp"

namespace egofocus::hil {

/// A frame of EVT3 words each 10 ms from the commit of the stream until its endpoint's halt is cleared, which
/// is how the driver stops a bulk stream. Source: USB Device Class Definition for Video Devices 1.0.
class EmulatedUvc : public EmulatedUsb {
 public:
  /// `feed` outlives the camera.
  explicit EmulatedUvc(EventFeed& feed);
  ~EmulatedUvc() override { unplug(); }

  [[nodiscard]] CameraTime& time() { return time_; }

 protected:
  bool control(const Setup& setup, Bytes& data) override;
  int in(std::uint8_t endpoint, std::size_t most, Bytes& data) override;
  void halt_cleared(std::uint8_t) override { time_.end(); }

 private:
  void make_frame(std::int64_t until_us);

  EventFeed& feed_;
  CameraTime time_;
  Bytes payload_;  // of the frame that is being sent
  std::size_t at_ = 0;
  Bytes stale_;  // what the receiver's memory holds
  std::uint8_t frame_id_ = 0;
};

}  // namespace egofocus::hil
