// Replay: the input is cut into events.raw, can.log and poses.txt, and played into small rings by polls whose
// time rises. Nothing may be dropped, the watermark may not fall, and the end must come.
#include <cstring>
#include <vector>

#include "core/inlets.hpp"
#include "fuzz/fuzz_input.hpp"
#include "hal/replay_source.hpp"

using namespace egofocus;

namespace {

template <typename Sample>
std::uint64_t drain(SpscRing<Sample>& ring) {
  std::uint64_t taken = 0;
  for (auto ready = ring.peek(64); !ready.empty(); ready = ring.peek(64)) {
    taken += ready.size();
    ring.release(ready.size());
  }
  return taken;
}

CanSignalRole role_of(const char* message, const char* signal, CanRole role) {
  CanSignalRole result;
  std::strcpy(result.message, message);
  std::strcpy(result.signal, signal);
  result.role = role;
  return result;
}

CanMotionDecoder configured() {
  constexpr std::string_view kDbc =
      "BO_ 1 A: 2 E\n SG_ v : 0|16@1+ (0.01,0) [0|0] \"\" X\n\n"
      "BO_ 2 B: 2 E\n SG_ z : 0|16@1- (0.001,0) [0|0] \"\" X\n\n"
      "BO_ 3 C: 2 E\n SG_ x : 0|16@1- (0.001,0) [0|0] \"\" X\n";
  static Dbc dbc;
  CanMotionConfig config;
  config.signals[config.signal_count++] = role_of("A", "v", CanRole::kWheelSpeed);
  config.signals[config.signal_count++] = role_of("B", "z", CanRole::kGyroZ);
  config.signals[config.signal_count++] = role_of("C", "x", CanRole::kGyroX);
  CanMotionDecoder decoder;
  fuzz::require(read_dbc(kDbc, {}, dbc).ok() && decoder.configure(config, dbc).ok());
  return decoder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const CanMotionDecoder kConfigured = configured();
  static CanMotionDecoder can_motion;
  can_motion = kConfigured;

  std::span<const std::byte> bytes = std::as_bytes(std::span(data, size));
  const std::size_t events_size = bytes.size() * fuzz::take_byte(bytes) / 256;
  const std::size_t can_size = (bytes.size() - (events_size < bytes.size() ? events_size : bytes.size())) / 2;
  const std::size_t events_end = events_size < bytes.size() ? events_size : bytes.size();
  ReplaySource replay({.events_raw = bytes.first(events_end),
                       .can_log = bytes.subspan(events_end, can_size),
                       .poses_txt = bytes.subspan(events_end + can_size),
                       .can_motion = &can_motion,
                       .can_lag_us = 5000});
  if (!replay.start().ok()) return 0;

  Event event_slots[8];
  ImuSample imu_slots[2];
  OdometrySample odometry_slots[2];
  PoseSample pose_slots[2];
  Inlets::Rings rings{SpscRing<Event>(event_slots), SpscRing<ImuSample>(imu_slots),
                      SpscRing<OdometrySample>(odometry_slots), SpscRing<PoseSample>(pose_slots)};
  Inlets inlets(rings);

  std::uint64_t taken = 0;
  const auto poll = [&](std::int64_t until_us) {
    const Delivery delivery = replay.poll(inlets, until_us);
    fuzz::require(delivery.watermark_us <= until_us);
    const std::uint64_t before = taken;
    taken += drain(rings.events) + drain(rings.imu) + drain(rings.odometry) + drain(rings.poses);
    // Whoever says that there is more must have brought something, or be at its time.
    fuzz::require(delivery.ended || taken > before || delivery.watermark_us == until_us);
    return delivery.ended;
  };
  for (std::int64_t until_us = -3; until_us < (1LL << 40); until_us = until_us * 2 + 7) poll(until_us);
  while (!poll(INT64_MAX)) {
  }
  const ReplayCounters n = replay.counters();
  fuzz::require(n.events_pushed == n.events.events && n.poses_pushed == n.poses.poses);
  fuzz::require(taken == n.events_pushed + n.poses_pushed + n.imu_pushed + n.odometry_pushed);
  fuzz::require(
      rings.events.dropped() + rings.imu.dropped() + rings.odometry.dropped() + rings.poses.dropped() == 0);
  return 0;
}
