// Input: what the kernel answers, call by call: errors, messages of any length with any control data,
// interfaces that come and go, clocks that jump.
#include <cerrno>
#include <cstring>

#include "core/inlets.hpp"
#include "fuzz/fuzz_input.hpp"
#include "hal/socketcan_source.hpp"

using namespace egofocus;
using fuzz::require;
using fuzz::take_byte;

namespace {

constexpr int kErrors[] = {EINTR, EAGAIN, ENETDOWN, ENODEV, ENOBUFS, EPERM, EIO, ENXIO};

struct Kernel {
  std::span<const std::byte> left;
  std::int64_t now_ns = 1'000'000'000;
  int open_sockets = 0;

  int choice(int good) {
    const std::uint8_t byte = take_byte(left);
    return byte < 200 ? good : -kErrors[byte % 8];
  }
  void copy(void* to, std::size_t bytes) {
    const std::size_t n = bytes < left.size() ? bytes : left.size();
    std::memcpy(to, left.data(), n);
    left = left.subspan(n);
  }
  int receive(mmsghdr* messages, unsigned count) {
    const int n = choice(take_byte(left) % static_cast<int>(count + 1));
    for (int i = 0; i < n; ++i) {
      msghdr& header = messages[i].msg_hdr;
      const unsigned kind = take_byte(left);
      messages[i].msg_len = kind < 100 ? 16 : kind < 200 ? 72 : kind - 190;
      copy(header.msg_iov->iov_base, messages[i].msg_len < 72 ? messages[i].msg_len : 72);
      header.msg_controllen = take_byte(left) % (header.msg_controllen + 1);
      copy(header.msg_control, header.msg_controllen);
      header.msg_flags = (kind & 1) != 0 && kind > 240 ? MSG_TRUNC : 0;
    }
    return n;
  }
};

Kernel& of(void* self) {
  return *static_cast<Kernel*>(self);
}

SocketCanIo io_of(Kernel& kernel) {
  SocketCanIo io;
  io.self = &kernel;
  io.open = [](void* s) noexcept {
    const int fd = of(s).choice(5);
    of(s).open_sockets += fd >= 0;
    return fd;
  };
  io.close = [](void* s, int) noexcept { return --of(s).open_sockets, 0; };
  io.set_option = [](void* s, int, int, int, const void*, socklen_t) noexcept { return of(s).choice(0); };
  io.index_of = [](void* s, int, const char*) noexcept { return of(s).choice(3); };
  io.bind = [](void* s, int, int) noexcept { return of(s).choice(0); };
  io.is_up = [](void* s, int, const char*) noexcept { return of(s).choice(take_byte(of(s).left) % 2); };
  io.set_up = [](void* s, int, const char*, bool) noexcept { return of(s).choice(0); };
  io.wait = [](void* s, int, std::int64_t us) noexcept {
    of(s).now_ns += us * 1000;
    return of(s).choice(1);
  };
  io.receive = [](void* s, int, mmsghdr* m, unsigned n) noexcept { return of(s).receive(m, n); };
  io.now_ns = [](void* s, bool realtime) noexcept -> std::int64_t {
    return of(s).now_ns +
           (realtime ? 1'700'000'000'000'000'000 + take_byte(of(s).left) * 1'000'000'000LL : 0);
  };
  return io;
}

constexpr std::string_view kDbc =
    "BO_ 7 A: 8 X\n SG_ A : 0|16@1- (1,0) [0|0] \"\" X\n SG_ V : 16|16@1- (1,0) [0|0] \"\" X\n"
    "BO_ 2565876352 B: 8 X\n SG_ B : 0|16@1+ (1,0) [0|0] \"\" X\n";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Dbc dbc;
  static CanMotionDecoder motion;
  static Event events[2];
  static ImuSample imu[64];
  static OdometrySample odometry[64];
  static PoseSample poses[2];
  CanMotionConfig config;
  config.match_parameter_group = true;
  const char* names[3][2] = {{"A", "A"}, {"A", "V"}, {"B", "B"}};
  const CanRole roles[3] = {CanRole::kGyroX, CanRole::kWheelSpeed, CanRole::kGyroY};
  for (std::size_t i = 0; i < 3; ++i) {
    std::memcpy(config.signals[i].message, names[i][0], 2);
    std::memcpy(config.signals[i].signal, names[i][1], 2);
    config.signals[i].role = roles[i];
  }
  config.signal_count = 3;
  require(read_dbc(kDbc, {}, dbc).ok() && motion.configure(config, dbc).ok());

  Kernel kernel{.left = std::as_bytes(std::span(data, size))};
  SocketCanConfig source_config;
  source_config.wait_for_interface = true;
  source_config.restart_after_us = 20000;
  source_config.hardware_time = take_byte(kernel.left) % 4 != 0;
  Inlets::Rings rings{SpscRing<Event>(events), SpscRing<ImuSample>(imu), SpscRing<OdometrySample>(odometry),
                      SpscRing<PoseSample>(poses)};
  Inlets inlets(rings);
  {
    SocketCanSource source(source_config, motion, {}, io_of(kernel));
    if (source.start().ok()) {
      for (int i = 0; i < 1000 && !kernel.left.empty(); ++i) {
        const Delivery delivery = source.poll(inlets, 10000);
        require(delivery.status.ok() && !delivery.ended);
        for (const ImuSample& sample : rings.imu.peek(64)) require(sample.t_us <= kernel.now_ns / 1000);
        rings.imu.release(rings.imu.peek(64).size());
      }
      SocketCanHealth health;
      require(source.health(health));
      require(health.motion.frames == health.frames);
      require((health.link == CanLink::kGone) == (kernel.open_sockets == 0));
    }
    require(kernel.open_sockets <= 1);
  }
  require(kernel.open_sockets == 0);
  return 0;
}
