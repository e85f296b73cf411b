#include "robot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "device_facts.hpp"
#include "simulated_time.hpp"

namespace egofocus::reliability {
namespace {

using test::SlidingScene;

constexpr std::int64_t kImuEvery_us = 5'000;
constexpr std::int64_t kWheelEvery_us = 20'000;
constexpr std::int64_t kLateness_us = 10'000;
constexpr std::int64_t kTransfer_us = 500;  // what a few of them take at most
constexpr double kGravity_m_s2 = 9.80665;

constexpr const char* kDbc = R"(VERSION ""
NS_ :
BS_:
BU_: Robot
BO_ 256 Gyro: 6 Robot
 SG_ X : 0|16@1- (0.001,0) [-32|32] "rad/s" Robot
 SG_ Y : 16|16@1- (0.001,0) [-32|32] "rad/s" Robot
 SG_ Z : 32|16@1- (0.001,0) [-32|32] "rad/s" Robot
BO_ 257 Accel: 6 Robot
 SG_ X : 0|16@1- (0.002,0) [-64|64] "m/s2" Robot
 SG_ Y : 16|16@1- (0.002,0) [-64|64] "m/s2" Robot
 SG_ Z : 32|16@1- (0.002,0) [-64|64] "m/s2" Robot
BO_ 258 Wheel: 2 Robot
 SG_ Speed : 0|16@1- (0.001,0) [-32|32] "m/s" Robot
)";

void require(const Status& status, const char* what) {
  if (status.ok()) return;
  char text[300];
  status.describe(text);
  std::fprintf(stderr, "robot: %s: %s\n", what, text);
  std::abort();
}

CanSignalRole role(const char* message, const char* signal, CanRole what) {
  CanSignalRole entry;
  std::snprintf(entry.message, sizeof entry.message, "%s", message);
  std::snprintf(entry.signal, sizeof entry.signal, "%s", signal);
  entry.role = what;
  return entry;
}

std::unique_ptr<CanMotionDecoder> make_decoder() {
  const auto dbc = std::make_unique<Dbc>();
  require(read_dbc(kDbc, {}, *dbc), "DBC");
  CanMotionConfig config;
  for (const CanSignalRole& entry :
       {role("Gyro", "X", CanRole::kGyroX), role("Gyro", "Y", CanRole::kGyroY),
        role("Gyro", "Z", CanRole::kGyroZ), role("Accel", "X", CanRole::kAccelX),
        role("Accel", "Y", CanRole::kAccelY), role("Accel", "Z", CanRole::kAccelZ),
        role("Wheel", "Speed", CanRole::kWheelSpeed)}) {
    config.signals[config.signal_count++] = entry;
  }
  config.group_window_us = 1'000;
  auto decoder = std::make_unique<CanMotionDecoder>();
  require(decoder->configure(config, *dbc), "CAN signals");
  return decoder;
}

scripted::Camera small_davis() {
  scripted::Camera camera = scripted::davis346();
  camera.registers[scripted::at(1, 0)] = SlidingScene::kWidth;
  camera.registers[scripted::at(1, 1)] = SlidingScene::kHeight;
  // Its count of dropped events: none.
  for (std::uint32_t parameter = 81; parameter < 90; ++parameter)
    camera.registers[scripted::at(0, parameter)] = 0;
  return camera;
}

// 16-bit values, least significant byte first.
void send_frame(test::ScriptedCan& kernel, std::uint32_t id, std::initializer_list<double> values,
                double unit) {
  test::Scripted& next = kernel.frame(id, {});
  for (const double value : values) {
    const auto raw = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(value / unit)));
    next.frame.data[next.frame.len++] = static_cast<std::uint8_t>(raw & 0xff);
    next.frame.data[next.frame.len++] = static_cast<std::uint8_t>(raw >> 8);
  }
}

}  // namespace

Config Robot::engine_config() {
  Config config = SlidingScene::config();
  config.motion.source = MotionSource::kOdometry;
  config.motion.model = MotionModel::kWheeled;
  // The camera looks to the left: its right is the robot's forward.
  constexpr double kLooksLeft[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};
  std::copy(std::begin(kLooksLeft), std::end(kLooksLeft), config.motion.camera_from_body);
  config.window.max_events = 16'000;
  config.window.min_events = 3'000;      // of some 4,000 that it holds
  config.window.max_age_us = 1'000'000;  // 12 px of parallax at the wall
  config.rate.lateness_us = kLateness_us;
  return config;
}

Robot::Robot(const Config& config, const SocketCanConfig& can)
    : motion_(make_decoder()), usb_io_(bus.io()), engine_(config) {
  set_time_us(now_us_);
  bus.cameras = {small_davis()};
  bus.clock.set(now_us_);
  const UsbCameraSettings settings;
  buffers_.resize(UsbCameraSource::buffer_bytes(settings));
  usb_ = std::make_unique<UsbCameraSource>(settings, buffers_, usb_io_, bus.clock.clock());
  can_ = std::make_unique<SocketCanSource>(can, *motion_, CanTap{}, kernel.io());
  require(engine_.status, "engine");
  require(engine_->watch_events({this,
                                 [](void* self, std::span<const Event> events) noexcept {
                                   static_cast<Robot*>(self)->compare_times(events);
                                 }}),
          "tap");
  require(usb_->open(), "camera");
  require(usb_->start(), "camera");
  require(can_->start(), "CAN");
  require(engine_->start(ClockKind::kMonotonic, now_us_ + 50'000), "engine");
}

Robot::~Robot() {
  engine_->stop();
  can_->stop();
  usb_->stop();
}

void Robot::run(std::int64_t us) {
  for (const std::int64_t end_us = now_us_ + us; now_us_ < end_us;) {
    const std::int64_t from_us = now_us_;
    now_us_ += kStep_us;
    poll_camera(now_us_ - kTransfer_us);
    film(now_us_ - kTransfer_us);
    poll_camera(now_us_);
    speak(from_us, now_us_);
    Inlets inlets = engine_->inlets();
    for (int i = 0; i < 4; ++i) static_cast<void>(can_->poll(inlets, 0));
    set_time_us(now_us_);
    tick();
  }
}

// What the script has used up goes, so that this program's memory stays as it is.
void Robot::poll_camera(std::int64_t until_us) {
  Inlets inlets = engine_->inlets();
  while (bus.clock.now_us() < until_us) static_cast<void>(usb_->poll(inlets, until_us - bus.clock.now_us()));
  camera().writes.clear();
  if (camera().next_ending < camera().endings.size()) return;
  camera().endings.clear();
  camera().next_ending = 0;
}

// --- the camera --------------------------------------------------------------------------------------

std::int64_t Robot::device_us(std::int64_t t_us) const noexcept {
  return t_us - clock_begun_us_ + clock_leap_us_ + static_cast<std::int64_t>(std::floor(drifted_us_));
}

void Robot::reset_camera_clock() {
  begin_camera_clock(filmed_us_);
}

void Robot::begin_camera_clock(std::int64_t t_us) {
  inivation::Bytes bytes;
  clock_begun_us_ = t_us;
  clock_leap_us_ = 0;
  drifted_us_ = 0;
  writer_.reset(bytes);
  camera().endings.push_back({bytes, 0});
}

// What the world shows until then goes into one transfer; what jitter keeps back goes into the next.
void Robot::film(std::int64_t until_us) {
  if (trouble.jitter_us > 0)
    until_us -= std::uniform_int_distribution<std::int64_t>(0, trouble.jitter_us)(random_);
  if (until_us <= filmed_us_) return;
  const std::int64_t from_us = filmed_us_;
  const double passed_us = static_cast<double>(until_us - from_us);
  const double from_scene_us = scene_us_;
  speed_m_s_ += trouble.accel_m_s2 * passed_us * 1e-6;
  scene_us_ += passed_us * speed_m_s_ / SlidingScene::kSpeed_m_s;
  const double stretch = scene_us_ > from_scene_us ? passed_us / (scene_us_ - from_scene_us) : 0;
  std::vector<Event> events =
      scene_.events(static_cast<std::int64_t>(from_scene_us), static_cast<std::int64_t>(scene_us_));
  for (Event& event : events) {
    event.t_us =
        from_us + static_cast<std::int64_t>((static_cast<double>(event.t_us) - from_scene_us) * stretch);
    event.t_us = std::clamp(event.t_us, from_us + 1, until_us);
  }
  for (int pixel = 0; pixel < trouble.hot_pixels; ++pixel) {
    for (std::int64_t t_us = from_us + 1 + pixel; t_us <= until_us; t_us += 1'000'000 / kHotPixel_hz)
      events.push_back(
          {t_us, static_cast<std::uint16_t>(3 * pixel), static_cast<std::uint16_t>(2 * pixel), 1});
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t_us < b.t_us; });
  filmed_us_ = until_us;
  drifted_us_ += passed_us * trouble.drift_ppm * 1e-6;

  const bool streams = phase() == UsbCameraPhase::kStreaming && camera().is_plugged;
  if (!streams || trouble.camera_silent) {
    events_unseen += events.size();
    was_streaming_ = streams;
    return;
  }
  if (!was_streaming_) {
    begin_camera_clock(from_us);
    was_streaming_ = true;
  }
  inivation::Bytes bytes;
  for (const Event& event : events) {
    for (int i = 0; i < trouble.event_copies; ++i) writer_.event(bytes, device_us(event.t_us), event);
  }
  writer_.time(bytes, device_us(until_us));
  const std::uint64_t count = events.size() * static_cast<std::uint64_t>(trouble.event_copies);
  if (trouble.jitter_us > 0)
    for (const Event& event : events) true_times_us_.push_back(event.t_us);
  send(bytes, count);
}

void Robot::send(inivation::Bytes& bytes, std::uint64_t events) {
  if (trouble.corrupt_words > 0) {
    for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
      if (!chance(trouble.corrupt_words)) continue;
      bytes[at] = static_cast<std::byte>(random_());
      bytes[at + 1] = static_cast<std::byte>(random_());
    }
  }
  if (chance(trouble.short_transfers)) bytes.resize(bytes.size() / 4 * 2 + 1);
  int error = 0;
  if (chance(trouble.stalled_transfers)) error = EPIPE;
  if (chance(trouble.overflown_transfers)) {
    error = EOVERFLOW;
    bytes.clear();
  }
  if (error == EOVERFLOW) {
    events_unseen += events;
  } else {
    events_sent += events;
  }
  camera().endings.push_back({bytes, error});
}

// In the order in which they were sent: nothing is lost while there is jitter alone.
void Robot::compare_times(std::span<const Event> events) noexcept {
  for (const Event& event : events) {
    if (true_times_us_.empty()) return;
    const std::int64_t off_us = std::abs(event.t_us - true_times_us_.front());
    true_times_us_.pop_front();
    seen_.clock_error_us = std::max(seen_.clock_error_us, off_us);
  }
}

// --- the bus -----------------------------------------------------------------------------------------

void Robot::speak(std::int64_t from_us, std::int64_t to_us) {
  const auto found = kernel.interfaces.find("can0");
  const bool hears = found != kernel.interfaces.end() && found->second.up && !trouble.can_silent;
  for (std::int64_t t_us = from_us + 1; t_us <= to_us; ++t_us) {
    if (t_us % 1'000 != 0) continue;
    kernel.realtime_ns += t_us * 1000 - kernel.monotonic_ns;
    kernel.monotonic_ns = t_us * 1000;
    if (!hears) continue;
    if (t_us % kImuEvery_us == 0 && !trouble.imu_silent) {
      send_frame(kernel, 256, {0, 0, 0}, 0.001);
      send_frame(kernel, 257, {trouble.accel_m_s2, 0, kGravity_m_s2}, 0.002);
    }
    if (t_us % kWheelEvery_us == 0 && !trouble.wheel_silent) {
      if (!trouble.wheel_stuck) wheel_says_m_s_ = speed_m_s_;
      send_frame(kernel, 258, {wheel_says_m_s_}, 0.001);
    }
  }
}

// --- the engine --------------------------------------------------------------------------------------

void Robot::tick() {
  while (engine_->next_tick_us() + kLateness_us <= now_us_ && engine_->tick()) {
    events_sent_at_tick = events_sent;
    DepthFrame frame;
    if (engine_->newest(frame)) judge(frame);
  }
}

void Robot::judge(const DepthFrame& frame) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < frame.inverse_depth.size(); ++i) {
    if (frame.confidence[i] == 0) continue;
    const double inverse_m = frame.inverse_depth[i] * frame.inverse_depth_scale_per_m;
    errors.push_back(inverse_m > 0
                         ? std::abs(1 / inverse_m - SlidingScene::kDistance_m) / SlidingScene::kDistance_m
                         : 1e9);
  }
  double error = 1e9;
  if (errors.size() >= frame.inverse_depth.size() / 4) {
    const auto middle = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    error = *middle;
  }
  ++seen_.ticks;
  seen_.flags |= frame.flags;
  if (frame.flags == 0 && error <= kGood) {
    ++seen_.good;
    return;
  }
  seen_.not_good_us = now_us_;
  if (frame.flags != 0) return;
  ++seen_.poor_unflagged;
  seen_.worst_unflagged = std::max(seen_.worst_unflagged, error);
}

Seen Robot::look() {
  const Seen seen = seen_;
  seen_ = {};
  return seen;
}

std::map<std::string, std::uint64_t> Robot::counters() const {
  std::map<std::string, std::uint64_t> all;
  std::vector<daemon::DeviceFact> facts;
  daemon::tell(usb_->counters(), facts);
  SocketCanHealth bus_health;
  if (can_->health(bus_health)) daemon::tell(bus_health, facts);
  for (const daemon::DeviceFact& fact : facts)
    if (fact.is_counter) all[fact.name] = fact.value;
  const Health health = engine_->health();
  const EventCounters& e = health.events;
  all.insert({{"events_in", e.in},
              {"events_ring_dropped", e.ring_dropped},
              {"events_over_rate", e.over_rate},
              {"events_out_of_range", e.out_of_range},
              {"events_out_of_order", e.out_of_order},
              {"events_ahead", e.ahead},
              {"events_late", e.late},
              {"events_hot_pixel", e.hot_pixel},
              {"events_refractory", e.refractory},
              {"events_isolated", e.isolated},
              {"events_kept", e.kept},
              {"window_decimated", health.window.decimated},
              {"imu_in", health.imu.in},
              {"odometry_in", health.odometry.in},
              {"odometry_rejected", health.odometry.rejected},
              {"ticks_run", health.ticks.run},
              {"ticks_skipped", health.ticks.skipped}});
  return all;
}

}  // namespace egofocus::reliability
