// What a bus, an interface or the system can do to the source: nothing hangs, spins or is lost uncounted.
#include <linux/can/error.h>
#include <linux/can/raw.h>

#include <string>

#include "hal/socketcan_bench.hpp"

using namespace egofocus;

namespace {

std::string text_of(const Status& status) {
  char text[300];
  status.describe(text);
  return text;
}

void send_yaw(CanBench& bench) {
  bench.kernel.frame(0x174, {0, 0x80, 0, 0, 0, 0x80, 0, 0});
}

}  // namespace

TEST_CASE("socketcan: start says what is missing, and leaves nothing open") {
  CanBench none;
  none.kernel.interfaces.clear();
  CHECK(none.source.start().code() == StatusCode::kIo);
  CHECK(none.source.start().value() == ENODEV);
  CHECK(text_of(none.source.start()).find("ip link") != std::string::npos);
  CHECK(none.health().link == CanLink::kClosed);

  CanBench kernel;
  kernel.kernel.open_error = EAFNOSUPPORT;
  CHECK(text_of(kernel.source.start()).find("modprobe can-raw") != std::string::npos);

  CanBench ethernet;
  ethernet.kernel.interfaces["can0"].is_can = false;
  CHECK(text_of(ethernet.source.start()).find("no CAN bus") != std::string::npos);

  CanBench filters;
  filters.kernel.refused_options[CAN_RAW_FILTER] = ENOMEM;
  CHECK(filters.source.start().value() == ENOMEM);

  for (CanBench* bench : {&none, &kernel, &ethernet, &filters}) CHECK(bench->kernel.open_sockets == 0);
}

TEST_CASE("socketcan: an old kernel that lacks an option still gives frames") {
  CanBench bench;
  bench.kernel.refused_options[CAN_RAW_FD_FRAMES] = ENOPROTOOPT;
  bench.kernel.refused_options[SO_TIMESTAMPING] = EINVAL;
  REQUIRE(bench.source.start().ok());
  CHECK(bench.health().failed_calls == 2);
  CHECK(bench.health().last_errno == EINVAL);
  send_yaw(bench);
  bench.poll();
  CHECK(bench.health().frames == 1);
}

TEST_CASE("socketcan: an interface that is not there yet is waited for, when asked to, without spinning") {
  SocketCanConfig config;
  config.wait_for_interface = true;
  CanBench bench(config);
  bench.kernel.interfaces.clear();
  REQUIRE(bench.source.start().ok());
  CHECK(bench.health().link == CanLink::kGone);
  const int before = bench.kernel.calls;
  for (int i = 0; i < 1000; ++i) CHECK(bench.poll(10000).status.ok());  // 10 s
  CHECK(bench.kernel.waited_us == 10'000'000);
  CHECK(bench.kernel.opened <= 101);
  CHECK(bench.kernel.calls - before < 4500);
  CHECK(bench.kernel.open_sockets == 0);
  bench.kernel.interfaces["can0"] = {9};
  for (int i = 0; i < 11; ++i) bench.poll();
  CHECK(bench.health().link == CanLink::kUp);
  CHECK(bench.kernel.bound_index == 9);
}

TEST_CASE("socketcan: down and up: the same socket hears again") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  bench.kernel.interfaces["can0"].up = false;
  bench.kernel.fail(ENETDOWN);
  CHECK(bench.poll().status.ok());
  CHECK(bench.health().link == CanLink::kDown);
  for (int i = 0; i < 100; ++i) bench.poll();
  CHECK(bench.health().link == CanLink::kDown);
  CHECK(bench.kernel.waited_us == 1'000'000);
  bench.kernel.interfaces["can0"].up = true;
  for (int i = 0; i < 11; ++i) bench.poll();
  CHECK(bench.health().link == CanLink::kUp);
  CHECK(bench.health().link_downs == 1);
  CHECK(bench.health().link_losses == 0);
  CHECK(bench.kernel.opened == 1);
  send_yaw(bench);
  bench.poll();
  CHECK(bench.health().frames == 1);
}

TEST_CASE("socketcan: unplugged twenty times, each time it is heard again under another number") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  for (int i = 0; i < 20; ++i) {
    bench.kernel.fail(ENETDOWN);
    bench.kernel.fail(ENODEV);
    bench.kernel.interfaces.clear();
    for (int k = 0; k < 15; ++k) bench.poll();
    CHECK(bench.health().link == CanLink::kGone);
    CHECK(bench.kernel.open_sockets == 0);
    bench.kernel.queue.clear();
    bench.kernel.interfaces["can0"] = {20 + i};
    for (int k = 0; k < 11; ++k) bench.poll();
    CHECK(bench.health().link == CanLink::kUp);
    send_yaw(bench);
    bench.poll();
    CHECK(bench.health().frames == static_cast<std::uint64_t>(i) + 1);
  }
  CHECK(bench.health().link_losses == 20);
  CHECK(bench.health().opened == 21);
  CHECK(bench.kernel.open_sockets == 1);
  bench.source.stop();
  CHECK(bench.kernel.open_sockets == 0);
}

TEST_CASE("socketcan: removed and made anew while it was down, before anyone looked") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  bench.kernel.fail(ENETDOWN);
  bench.kernel.interfaces["can0"] = {44};
  for (int k = 0; k < 30; ++k) bench.poll();
  CHECK(bench.health().link == CanLink::kUp);
  CHECK(bench.kernel.bound_index == 44);
  CHECK(bench.health().opened == 2);
}

TEST_CASE("socketcan: interrupted calls and passing shortages end nothing") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  bench.kernel.wait_errors = {EINTR, EINTR};
  bench.poll();
  bench.poll();
  for (const int error : {EINTR, ENOBUFS, EAGAIN}) bench.kernel.fail(error);
  for (int i = 0; i < 3; ++i) bench.poll();
  send_yaw(bench);
  bench.poll();
  CHECK(bench.health().frames == 1);
  CHECK(bench.health().link == CanLink::kUp);
  CHECK(bench.health().opened == 1);
  CHECK(bench.health().failed_calls == 1);
  CHECK(bench.health().last_errno == ENOBUFS);

  bench.kernel.fail(EIO);  // unknown: a new socket
  bench.poll();
  for (int i = 0; i < 11; ++i) bench.poll();
  CHECK(bench.health().opened == 2);
  bench.kernel.wait_errors = {EBADF};
  bench.poll();
  for (int i = 0; i < 11; ++i) bench.poll();
  CHECK(bench.health().opened == 3);
  CHECK(bench.kernel.open_sockets == 1);
}

TEST_CASE("socketcan: states of the controller, and what each error frame adds") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  const auto state_after = [&](std::uint32_t classes, std::initializer_list<int> bytes) {
    bench.kernel.error_frame(classes, bytes);
    bench.poll();
    return bench.health().bus;
  };
  CHECK(state_after(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_WARNING, 0, 0, 0, 0, 0, 0}) == CanBusState::kWarning);
  CHECK(state_after(CAN_ERR_CRTL | 0x200, {0, 0x20 | 0x08, 0, 0, 0, 0, 130, 7}) == CanBusState::kPassive);
  CHECK(bench.health().errors.tx_errors == 130);
  CHECK(bench.health().errors.rx_errors == 7);
  CHECK(state_after(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_RX_OVERFLOW, 0, 0, 0, 0, 0, 0}) == CanBusState::kPassive);
  CHECK(bench.health().errors.rx_overflows == 1);
  CHECK(state_after(CAN_ERR_CRTL, {0, CAN_ERR_CRTL_ACTIVE, 0, 0, 0, 0, 0, 0}) == CanBusState::kActive);
  CHECK(state_after(CAN_ERR_BUSOFF, {}) == CanBusState::kOff);
  CHECK(state_after(CAN_ERR_RESTARTED, {}) == CanBusState::kActive);
  CHECK(state_after(CAN_ERR_BUSOFF | CAN_ERR_ACK | CAN_ERR_BUSERROR | CAN_ERR_TRX | CAN_ERR_TX_TIMEOUT, {}) ==
        CanBusState::kOff);
  send_yaw(bench);
  bench.poll();
  CHECK(bench.health().bus == CanBusState::kActive);  // it hears
  const CanErrorCounters n = bench.health().errors;
  CHECK(n.frames == 7);
  CHECK(n.warnings == 2);
  CHECK(n.passive == 1);
  CHECK(n.bus_off == 2);
  CHECK(n.restarted == 1);
  CHECK(n.no_ack == 1);
  CHECK(n.bus_errors == 1);
  CHECK(n.transceiver == 1);
  CHECK(n.other == 1);
}

TEST_CASE("socketcan: bus-off is reported and left alone unless configured") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  bench.kernel.error_frame(CAN_ERR_BUSOFF, {});
  for (int i = 0; i < 1000; ++i) bench.poll();
  CHECK(bench.health().bus == CanBusState::kOff);
  CHECK(bench.kernel.links_set.empty());
}

TEST_CASE("socketcan: a bus-off node is set down and up after the configured time") {
  SocketCanConfig config;
  config.restart_after_us = 500000;
  CanBench bench(config);
  REQUIRE(bench.source.start().ok());
  bench.kernel.error_frame(CAN_ERR_BUSOFF, {});
  for (int i = 0; i < 49; ++i) bench.poll();
  CHECK(bench.kernel.links_set.empty());
  for (int i = 0; i < 20; ++i) bench.poll();
  CHECK(bench.kernel.links_set == std::vector<bool>{false, true});
  CHECK(bench.health().restarts == 1);
  CHECK(bench.health().bus == CanBusState::kActive);
  CHECK(bench.health().link == CanLink::kUp);
  send_yaw(bench);
  bench.poll();
  CHECK(bench.health().frames == 1);
}

TEST_CASE("socketcan: without the right to restart it says so and goes on asking, slowly") {
  SocketCanConfig config;
  config.restart_after_us = 500000;
  CanBench bench(config);
  bench.kernel.set_up_error = EPERM;
  REQUIRE(bench.source.start().ok());
  bench.kernel.error_frame(CAN_ERR_BUSOFF, {});
  for (int i = 0; i < 300; ++i) bench.poll();  // 3 s
  CHECK(bench.health().restarts == 0);
  CHECK(bench.health().restarts_refused >= 5);
  CHECK(bench.health().restarts_refused <= 6);
  CHECK(bench.health().last_errno == EPERM);
  CHECK(bench.health().bus == CanBusState::kOff);
}

TEST_CASE("socketcan: stop closes, start begins anew") {
  CanBench bench;
  REQUIRE(bench.source.start().ok());
  send_yaw(bench);
  bench.poll();
  bench.source.stop();
  CHECK(bench.health().link == CanLink::kClosed);
  REQUIRE(bench.source.start().ok());
  CHECK(bench.health().frames == 0);
  REQUIRE(bench.source.start().ok());
  CHECK(bench.kernel.open_sockets == 1);
}
