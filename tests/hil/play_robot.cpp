// The robot from the other side: plays the recording in this folder (events.raw, can.log) as a camera and a
// bus would send it, again and again, from the moment that somebody starts the camera; until it is killed.
//
//   hil_play_robot davis|v4l2 vcan0|adapter [SOCKET FIRST_TICK_US]
//
// vcan0: frames at the speed of their recording. adapter: can0, whose time stamps are the recording's times,
// as if its clock and the camera's were one; CLOCK_REALTIME must stand below 30 minutes. SOCKET: never far
// beyond the next tick of the daemon there, for one that goes by the devices' time and takes long.
#include <memory>

#include "egofocus/depth_reader.h"
#include "hil/can_bench.hpp"
#include "hil/can_link.hpp"
#include "hil/can_sender.hpp"
#include "hil/emulated_can_adapter.hpp"
#include "hil/emulated_davis.hpp"
#include "hil/emulated_uvc.hpp"
#include "hil/recorded.hpp"

using namespace egofocus;
using namespace egofocus::hil;

namespace {

constexpr std::int64_t kAheadOfCamera_us = 200'000;
constexpr std::int64_t kAheadOfDepth_us = 100'000;  // less than the buffers of a video node hold

class VirtualBus {
 public:
  explicit VirtualBus(const char* name) : sender_(name) { REQUIRE(sender_.is_open()); }
  void send(const CanFrame& frame, std::int64_t) { REQUIRE_QUIET(sender_.send(frame)); }

 private:
  static void REQUIRE_QUIET(bool truth) {
    if (!truth) std::exit(1);
  }
  CanSender sender_;
};

/// The kernel adds a number of its own to an adapter's stamps: a frame that nobody else wants shows it.
class SynchronisedAdapter {
 public:
  SynchronisedAdapter() {
    REQUIRE(adapter_.plug_when_free(1));
    REQUIRE(raise_can("can0"));
    SocketCanConfig config = config_of("can0");
    config.device_time = true;
    Bench bench(config);
    REQUIRE(bench.source.start().ok());
    constexpr std::uint8_t kYaw[] = {0, 0};
    adapter_.frame_at(0, 7, kYaw);
    REQUIRE(bench.poll_until_frames(1));
    zero_us_ = static_cast<std::uint32_t>(-bench.imu().front().t_us);
  }
  void send(const CanFrame& frame, std::int64_t t_us) {
    adapter_.frame_at(zero_us_ + static_cast<std::uint32_t>(t_us),
                      frame.id | (frame.extended ? CAN_EFF_FLAG : 0), {frame.data, frame.length});
  }

 private:
  EmulatedCanAdapter adapter_;
  std::uint32_t zero_us_ = 0;  // the stamp that becomes 0
};

/// Moves the camera's limit with the depth that comes.
class Listener {
 public:
  Listener(CameraTime& time, const char* socket, std::int64_t first_tick_us)
      : time_(time), socket_(socket), first_tick_us_(first_tick_us) {
    limit();
  }
  ~Listener() { egofocus_depth_close(&reader_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  void look() {
    if (reader_.socket < 0 && egofocus_depth_open(&reader_, socket_) != 0) return;
    const int news = egofocus_depth_wait(&reader_, 0);
    if (news < 0) {  // another daemon, another beginning
      egofocus_depth_close(&reader_);
      depth_us_ = 0;
    } else if (news > 0) {
      const std::size_t pixels = egofocus_depth_pixels(&reader_);
      std::vector<std::uint16_t> depth(pixels);
      std::vector<std::uint8_t> confidence(pixels);
      egofocus_depth_info info;
      if (egofocus_depth_newest(&reader_, &info, depth.data(), confidence.data()) == 1) depth_us_ = info.t_us;
    }
    limit();
  }

 private:
  void limit() { time_.limit(std::max(depth_us_, first_tick_us_) + kAheadOfDepth_us); }

  CameraTime& time_;
  const char* socket_;
  std::int64_t first_tick_us_;
  std::int64_t depth_us_ = 0;
  egofocus_depth_reader reader_{
      .socket = -1, .memory = nullptr, .bytes = 0, .shape = {}, .last = 0, .missed = 0};
};

template <typename Bus>
[[noreturn]] void play(Bus& bus, const Recorded& recorded, CameraTime& time, Listener* listener) {
  std::uint64_t starts = 0;
  std::size_t at = 0;
  std::int64_t begin_us = 0;
  for (;; usleep(1000)) {
    if (listener != nullptr) listener->look();
    if (!time.runs()) continue;
    if (time.starts() != starts) {
      starts = time.starts();
      at = 0;
      begin_us = 0;
    }
    const std::int64_t until_us = std::min(time.now_us(), time.sent_us() + kAheadOfCamera_us);
    for (; recorded.frames[at].t_us + begin_us <= until_us;) {
      bus.send(recorded.frames[at], recorded.frames[at].t_us + begin_us);
      if (++at < recorded.frames.size()) continue;
      at = 0;
      begin_us += recorded.lap_us;
    }
  }
}

template <typename Camera>
void play_all(const Recorded& recorded, const std::string& bus, const char* socket,
              const char* first_tick_us) {
  RecordedEvents feed(recorded.events, recorded.lap_us);
  Camera camera(feed);
  std::unique_ptr<Listener> listener;
  if (socket != nullptr)
    listener = std::make_unique<Listener>(camera.time(), socket, std::atoll(first_tick_us));
  REQUIRE(camera.plug_when_free(0));
  if (bus == "adapter") {
    SynchronisedAdapter adapter;
    play(adapter, recorded, camera.time(), listener.get());
  }
  VirtualBus virtual_bus(bus.c_str());
  play(virtual_bus, recorded, camera.time(), listener.get());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string camera = argc > 1 ? argv[1] : "";
  if ((argc != 3 && argc != 5) || (camera != "davis" && camera != "v4l2")) {
    std::fputs("usage: hil_play_robot davis|v4l2 vcan0|adapter [SOCKET FIRST_TICK_US]\n", stderr);
    return 2;
  }
  const auto recorded = read_recorded(".");
  REQUIRE(recorded.has_value());
  const char* const socket = argc == 5 ? argv[3] : nullptr;
  const char* const first_tick_us = argc == 5 ? argv[4] : nullptr;
  if (camera == "davis") {
    play_all<EmulatedDavis>(*recorded, argv[2], socket, first_tick_us);
  } else {
    play_all<EmulatedUvc>(*recorded, argv[2], socket, first_tick_us);
  }
  return 0;
}
