// A SocketCAN source on a real interface: a yaw rate in message 7 is all it wants.
#pragma once

#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "core/clock.hpp"
#include "core/inlets.hpp"
#include "hal/socketcan_source.hpp"
#include "hil/expect.hpp"

namespace egofocus::hil {

inline constexpr std::string_view kYawDbc =
    "BO_ 7 Yaw: 2 X\n SG_ Rate : 0|16@1- (0.001,0) [0|0] \"rad/s\" X\n";

inline std::int64_t now_us() {
  const Clock clock = monotonic_clock();
  return clock.now_us(clock.self);
}

inline void shell(const std::string& line) {
  const int code = std::system(line.c_str());
  if (code != 0) std::printf("       `%s` gave %d\n", line.c_str(), code);
}

/// Bound to an interface; sends and never reads.
class Sender {
 public:
  explicit Sender(const char* interface_name) : fd_(socket(PF_CAN, SOCK_RAW, CAN_RAW)) {
    const int on = 1;
    (void)setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0);
    (void)setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface_name));
    REQUIRE(bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  ~Sender() { close(fd_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  bool send(canid_t id, std::int16_t value, std::size_t mtu = CAN_MTU) const {
    canfd_frame frame{};
    frame.can_id = id;
    frame.len = mtu == CAN_MTU ? 2 : 64;
    std::memcpy(frame.data, &value, sizeof value);
    return write(fd_, &frame, mtu) == static_cast<ssize_t>(mtu);
  }

 private:
  int fd_;
};

inline void add_role(CanMotionConfig& config, const char* message, const char* signal, CanRole role) {
  CanSignalRole& entry = config.signals[config.signal_count++];
  std::strcpy(entry.message, message);
  std::strcpy(entry.signal, signal);
  entry.role = role;
}

inline CanMotionConfig yaw_alone() {
  CanMotionConfig config;
  add_role(config, "Yaw", "Rate", CanRole::kGyroZ);
  return config;
}

class Bench {
 public:
  explicit Bench(const SocketCanConfig& config, std::string_view dbc_text = kYawDbc,
                 const CanMotionConfig& motion = yaw_alone())
      : source(config, configured(motion_, dbc_text, motion)) {}

  /// Polls for this long, or until the link is as wanted.
  void poll_for(std::int64_t time_us) {
    const std::int64_t end_us = now_us() + time_us;
    do {
      if (!source.poll(inlets, 10000).status.ok()) ++bad_polls;
    } while (now_us() < end_us);
  }
  bool poll_until_link(CanLink link, std::int64_t limit_us = 20'000'000) {
    const std::int64_t end_us = now_us() + limit_us;
    while (health().link != link && now_us() < end_us) poll_for(1);
    return health().link == link;
  }
  bool poll_until_frames(std::uint64_t frames, std::int64_t limit_us = 20'000'000) {
    const std::int64_t end_us = now_us() + limit_us;
    while (health().frames < frames && now_us() < end_us) poll_for(1);
    return health().frames == frames;
  }
  [[nodiscard]] SocketCanHealth health() const {
    SocketCanHealth result;
    REQUIRE_QUIET(source.health(result));
    return result;
  }
  std::vector<ImuSample> imu() {
    const auto all = rings_.imu.peek(1024);
    std::vector<ImuSample> result(all.begin(), all.end());
    rings_.imu.release(all.size());
    return result;
  }

 private:
  static void REQUIRE_QUIET(bool truth) {
    if (!truth) std::exit(1);
  }
  static CanMotionDecoder& configured(CanMotionDecoder& decoder, std::string_view dbc_text,
                                      const CanMotionConfig& motion) {
    static Dbc dbc;
    REQUIRE(read_dbc(dbc_text, {}, dbc).ok());
    REQUIRE(decoder.configure(motion, dbc).ok());
    return decoder;
  }

  std::vector<Event> events_ = std::vector<Event>(2);
  std::vector<ImuSample> imu_ = std::vector<ImuSample>(1024);
  std::vector<OdometrySample> odometry_ = std::vector<OdometrySample>(2);
  std::vector<PoseSample> poses_ = std::vector<PoseSample>(2);
  Inlets::Rings rings_{SpscRing<Event>(events_), SpscRing<ImuSample>(imu_),
                       SpscRing<OdometrySample>(odometry_), SpscRing<PoseSample>(poses_)};
  CanMotionDecoder motion_;

 public:
  int bad_polls = 0;
  Inlets inlets{rings_};
  SocketCanSource source;
};

inline SocketCanConfig config_of(const char* interface_name) {
  SocketCanConfig config;
  std::strcpy(config.interface_name, interface_name);
  return config;
}

}  // namespace egofocus::hil
