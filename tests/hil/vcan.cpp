// The SocketCAN source on the kernel's virtual CAN bus: frames, stamps, filters, overflow, an interface that
// goes down, vanishes and comes back, a wall clock that is set.
#include <ctime>

#include "hil/can_bench.hpp"

using namespace egofocus;
using namespace egofocus::hil;

namespace {

void make_vcan() {
  shell("ip link add dev vcan0 type vcan && ip link set vcan0 mtu 72 && ip link set vcan0 up");
}

std::string text_of(const Status& status) {
  char text[300];
  status.describe(text);
  return text;
}

void frames_and_stamps() {
  Bench bench(config_of("vcan0"));
  REQUIRE(bench.source.start().ok());
  const Sender sender("vcan0");
  // The kernel begins to stamp a moment after the first socket asked for it.
  REQUIRE(sender.send(7, 0));
  bench.poll_for(200000);
  (void)bench.imu();
  const std::int64_t before_us = now_us();
  REQUIRE(sender.send(7, 500));
  const std::int64_t after_us = now_us();
  usleep(300000);  // a stamp is the kernel's, not the time of reading
  bench.poll_for(10000);
  const auto imu = bench.imu();
  REQUIRE(imu.size() == 1);
  EXPECT(imu[0].gyro_rad_s[2] == 0.5);
  std::printf("       stamped %lld us after it was sent, %lld us allowed\n",
              static_cast<long long>(imu[0].t_us - before_us), static_cast<long long>(after_us - before_us));
  EXPECT(imu[0].t_us >= before_us - 100 && imu[0].t_us <= after_us + 100);

  for (int i = 0; i < 200; ++i) (void)sender.send(static_cast<canid_t>(0x100 + i), 1);
  (void)sender.send(7 | CAN_EFF_FLAG, 1);
  (void)sender.send(7 | CAN_RTR_FLAG, 1);
  REQUIRE(sender.send(7, 1000, CANFD_MTU));
  bench.poll_for(100000);
  EXPECT(bench.imu().size() == 1);
  EXPECT(bench.health().frames == 3);
  EXPECT(bench.health().motion.frames_unknown == 0);
  EXPECT(bench.health().remote_frames == 0);
  EXPECT(bench.health().failed_calls == 0);

  // The wall clock jumps an hour: samples stay on the monotonic clock.
  timespec wall{};
  clock_gettime(CLOCK_REALTIME, &wall);
  wall.tv_sec += 3600;
  REQUIRE(clock_settime(CLOCK_REALTIME, &wall) == 0);
  const std::int64_t sent_us = now_us();
  REQUIRE(sender.send(7, 1));
  bench.poll_for(50000);
  const auto later = bench.imu();
  REQUIRE(later.size() == 1);
  EXPECT(later[0].t_us >= sent_us - 100 && later[0].t_us <= sent_us + 50000);
  EXPECT(bench.bad_polls == 0);
}

void overflow() {
  SocketCanConfig config = config_of("vcan0");
  config.receive_buffer_bytes = 2048;
  Bench bench(config);
  REQUIRE(bench.source.start().ok());
  const Sender sender("vcan0");
  for (int i = 0; i < 2000; ++i) (void)sender.send(7, 1);
  bench.poll_for(50000);
  const std::uint64_t kept = bench.health().frames;
  EXPECT(kept > 0 && kept < 2000);
  REQUIRE(sender.send(7, 2));  // the next frame tells what was lost
  bench.poll_for(50000);
  std::printf("       2000 sent at once: %llu came, %llu reported lost\n",
              static_cast<unsigned long long>(kept),
              static_cast<unsigned long long>(bench.health().kernel_dropped));
  EXPECT(bench.health().kernel_dropped == 2000 - kept);
}

void down_gone_and_back() {
  Bench bench(config_of("vcan0"));
  REQUIRE(bench.source.start().ok());
  std::uint64_t frames = 0;
  for (int i = 0; i < 5; ++i) {
    shell("ip link set vcan0 down");
    EXPECT(bench.poll_until_link(CanLink::kDown));
    bench.poll_for(150000);
    EXPECT(bench.health().link == CanLink::kDown);
    shell("ip link set vcan0 up");
    EXPECT(bench.poll_until_link(CanLink::kUp));
    EXPECT(Sender("vcan0").send(7, 1) && bench.poll_until_frames(++frames));
  }
  EXPECT(bench.health().opened == 1);
  for (int i = 0; i < 20; ++i) {
    shell("ip link del vcan0");
    EXPECT(bench.poll_until_link(CanLink::kGone));
    make_vcan();
    EXPECT(bench.poll_until_link(CanLink::kUp));
    EXPECT(Sender("vcan0").send(7, 1) && bench.poll_until_frames(++frames));
  }
  EXPECT(bench.health().link_losses == 20);
  EXPECT(bench.bad_polls == 0);
}

void waiting_is_bounded_and_idle() {
  SocketCanConfig config = config_of("vcan9");
  Bench absent(config);
  EXPECT(absent.source.start().value() == ENODEV);
  config.wait_for_interface = true;
  Bench bench(config);
  REQUIRE(bench.source.start().ok());
  timespec cpu_before{}, cpu_after{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu_before);
  const std::int64_t begin_us = now_us();
  for (int i = 0; i < 100; ++i) (void)bench.source.poll(bench.inlets, 10000);
  const std::int64_t waited_us = now_us() - begin_us;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu_after);
  const double cpu_s = static_cast<double>(cpu_after.tv_sec - cpu_before.tv_sec) +
                       static_cast<double>(cpu_after.tv_nsec - cpu_before.tv_nsec) * 1e-9;
  std::printf("       100 polls of 10 ms: %lld ms, %.1f ms of processor\n",
              static_cast<long long>(waited_us / 1000), cpu_s * 1e3);
  EXPECT(waited_us >= 900000);
  EXPECT(cpu_s * 1e6 < static_cast<double>(waited_us) * 0.3);
}

void refusals() {
  Bench loopback(config_of("lo"));
  const std::string text = text_of(loopback.source.start());
  std::printf("       %s\n", text.c_str());
  EXPECT(text.find("no CAN bus") != std::string::npos);
}

}  // namespace

int main() {
  {
    Bench bench(config_of("vcan0"));
    const std::string text = text_of(bench.source.start());
    std::printf("       %s\n", text.c_str());
    EXPECT(text.find("modprobe can-raw") != std::string::npos);
  }
  shell("modprobe can-raw && modprobe vcan");
  make_vcan();
  frames_and_stamps();
  overflow();
  down_gone_and_back();
  waiting_is_bounded_and_idle();
  refusals();
  return failures != 0;
}
