#include "hal/can_motion_decoder.hpp"

#include <string_view>

namespace egofocus {
namespace {

constexpr double kRadPerDeg = 3.14159265358979323846 / 180.0;
constexpr double kStandardGravity = 9.80665;  // m/s^2
constexpr std::uint32_t kStandardIdMask = 0x7FF;
constexpr std::uint32_t kExtendedIdMask = 0x1FFFFFFF;

double si_per(CanUnit unit) noexcept {
  switch (unit) {
    case CanUnit::kSi:
      break;
    case CanUnit::kDegPerSecond:
      return kRadPerDeg;
    case CanUnit::kStandardGravity:
      return kStandardGravity;
    case CanUnit::kKmPerHour:
      return 1.0 / 3.6;
  }
  return 1.0;
}

bool is_finite(double value) noexcept {
  return value - value == 0;
}

// SAE J1939-21: priority (3 bits), parameter group (18), source address (8). Where the group's PF byte is
// below 240, its lowest byte is the destination and not part of the group.
std::uint32_t parameter_group_mask(std::uint32_t id) noexcept {
  return (id >> 16 & 0xFF) < 240 ? 0x03FF0000 : 0x03FFFF00;
}

// Configured names may lack their NUL.
std::string_view name_of(const char (&text)[kMaxDbcName + 1]) noexcept {
  std::size_t length = 0;
  while (length < kMaxDbcName && text[length] != '\0') ++length;
  return {text, length};
}

// Times come from outside: a difference may not fit into int64.
std::uint64_t distance(std::int64_t a_us, std::int64_t b_us) noexcept {
  const auto a = static_cast<std::uint64_t>(a_us);
  const auto b = static_cast<std::uint64_t>(b_us);
  return a_us > b_us ? a - b : b - a;
}

std::int64_t minus_delay(std::int64_t t_us, std::int64_t delay_us) noexcept {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(t_us) - static_cast<std::uint64_t>(delay_us));
}

}  // namespace

Status CanMotionDecoder::configure(const CanMotionConfig& config, const Dbc& dbc) noexcept {
  dbc_ = dbc;
  config_ = config;
  route_count_ = 0;
  part_count_ = 0;
  wheels_ = 0;
  counters_ = {};
  for (Group& group : groups_) group = Group{};

  const Status status = build();
  if (!status.ok()) route_count_ = 0;
  return status;
}

Status CanMotionDecoder::build() noexcept {
  const std::size_t count = config_.signal_count;
  if (count == 0 || count > CanMotionConfig::kMaxSignals) {
    return {StatusCode::kBadMotion, "number of CAN signals, 1..32", static_cast<std::int64_t>(count)};
  }
  if (!is_permutation(config_.gyro_axes))
    return {StatusCode::kBadMotion, "gyro axes, a signed permutation of 1 2 3"};
  if (!is_permutation(config_.accel_axes)) {
    return {StatusCode::kBadMotion, "accelerometer axes, a signed permutation of 1 2 3"};
  }
  if (config_.group_window_us < 0) {
    return {StatusCode::kBadMotion, "group window of CAN samples", config_.group_window_us};
  }

  // Entries of one message become neighbours: its route is made at its first entry.
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view name = name_of(config_.signals[i].message);
    bool done = false;
    for (std::size_t k = 0; k < i; ++k) done = done || name == name_of(config_.signals[k].message);
    if (done) continue;
    const DbcMessage* message = dbc_.find_message(name);
    if (message == nullptr) return missing(i);
    Route& route = routes_[route_count_++];
    route = Route{};
    const bool group = message->extended && (message->parameter_group || config_.match_parameter_group);
    route.filter = {message->id,
                    group               ? parameter_group_mask(message->id)
                    : message->extended ? kExtendedIdMask
                                        : kStandardIdMask,
                    message->extended};
    route.first_part = static_cast<std::uint8_t>(part_count_);
    for (std::size_t k = i; k < count; ++k) {
      if (name != name_of(config_.signals[k].message)) continue;
      const Status status = add_entry(k, *message, route);
      if (!status.ok()) return status;
    }
    route.part_count = static_cast<std::uint8_t>(part_count_ - route.first_part);
  }
  if ((groups_[kVelocity].wanted & 0b111) == 0 && groups_[kVelocity].wanted != 0) {
    return {StatusCode::kBadMotion, "variance of a velocity that has no signal"};
  }
  return {};
}

Status CanMotionDecoder::missing(std::size_t index) const noexcept {
  return {StatusCode::kMissingSignal, to_string(config_.signals[index].role),
          static_cast<std::int64_t>(index)};
}

Status CanMotionDecoder::add_entry(std::size_t index, const DbcMessage& message, Route& route) noexcept {
  const CanSignalRole& entry = config_.signals[index];
  const auto value = static_cast<std::int64_t>(index);
  const DbcSignal* found = dbc_.find_signal(message, name_of(entry.signal));
  if (found == nullptr) return missing(index);
  if (entry.scale == 0 || !is_finite(entry.scale) || !is_finite(entry.offset)) {
    return {StatusCode::kBadMotion, "scale or offset of a CAN signal", value};
  }
  const auto signal = static_cast<std::int16_t>(found - dbc_.signals);

  if (entry.role == CanRole::kCounter) {
    if (route.counter >= 0) return {StatusCode::kBadMotion, "a second counter in one CAN message", value};
    route.counter = signal;
    return {};
  }

  const auto role = static_cast<unsigned>(entry.role);
  if (role >= kCanRoles) return {StatusCode::kBadMotion, "a role that does not exist", value};
  Kind kind = kVelocity;
  unsigned slot = role - static_cast<unsigned>(CanRole::kVelocityX);
  if (entry.role <= CanRole::kGyroZ) {
    kind = kGyro;
    slot = role;
  } else if (entry.role <= CanRole::kAccelZ) {
    kind = kAccel;
    slot = role - static_cast<unsigned>(CanRole::kAccelX);
  } else if (entry.role == CanRole::kWheelSpeed) {
    kind = kWheel;
    slot = static_cast<unsigned>(wheels_++);
  }
  Group& group = groups_[kind];
  if (slot >= kMaxParts) return {StatusCode::kBadMotion, "more than 16 wheels", value};
  if ((group.wanted >> slot & 1) != 0) return {StatusCode::kBadMotion, "a role that is given twice", value};
  group.wanted |= 1u << slot;

  Part& part = parts_[part_count_++];
  part = Part{};
  part.signal = static_cast<std::uint16_t>(signal);
  part.raw_max = entry.raw_max;
  part.scale = entry.scale;
  part.offset = entry.offset;
  part.unit = si_per(entry.unit);
  part.kind = kind;
  part.slot = static_cast<std::uint8_t>(slot);
  return {};
}

const CanMotionDecoder::Route* CanMotionDecoder::find_route(const CanFrame& frame) const noexcept {
  for (std::size_t i = 0; i < route_count_; ++i) {
    if (routes_[i].filter.passes(frame)) return &routes_[i];
  }
  return nullptr;
}

std::size_t CanMotionDecoder::filters(std::span<CanFilter, CanMotionConfig::kMaxSignals> out) const noexcept {
  for (std::size_t i = 0; i < route_count_; ++i) out[i] = routes_[i].filter;
  return route_count_;
}

void CanMotionDecoder::feed(const CanFrame& frame, MotionSamples& out) noexcept {
  out.imu_count = 0;
  out.odometry_count = 0;
  ++counters_.frames;
  const Route* route = find_route(frame);
  if (route == nullptr) {
    ++counters_.frames_unknown;
    return;
  }
  const std::span<const std::uint8_t> data(frame.data, frame.length < 64 ? frame.length : std::size_t{64});
  SampleCount count;
  bool is_short = false;
  if (route->counter >= 0) {
    count.known = decode_raw(dbc_.signals[route->counter], data, count.value);
    is_short = !count.known;
  }
  for (std::size_t i = 0; i < route->part_count; ++i) {
    const Part& part = parts_[route->first_part + i];
    const DbcSignal& signal = dbc_.signals[part.signal];
    if (!is_present(dbc_, signal, data)) continue;
    std::uint64_t raw = 0;
    if (decode_raw(signal, data, raw)) {
      take(part, raw, frame.t_us, count, out);
    } else {
      is_short = true;
    }
  }
  ++(is_short ? counters_.frames_short : counters_.frames_used);
}

bool CanMotionDecoder::belongs(const Group& group, std::uint32_t bit, std::int64_t t_us,
                               SampleCount count) const noexcept {
  if ((group.there & bit) != 0) return false;
  if (distance(group.first_us, t_us) > static_cast<std::uint64_t>(config_.group_window_us)) return false;
  return !group.count.known || !count.known || group.count.value == count.value;
}

void CanMotionDecoder::take(const Part& part, std::uint64_t raw, std::int64_t t_us, SampleCount count,
                            MotionSamples& out) noexcept {
  Group& group = groups_[part.kind];
  const std::uint32_t bit = 1u << part.slot;
  if (group.there != 0 && !belongs(group, bit, t_us, count)) {
    ++counters_.samples_incomplete;
    group.there = 0;
  }
  if (group.there == 0) {
    group.first_us = t_us;
    group.count = count;
    group.invalid = false;
  }
  const double physical = physical_value(dbc_.signals[part.signal], raw);
  const double value = (physical * part.scale + part.offset) * part.unit;
  if (raw > part.raw_max || !is_finite(value)) {
    ++counters_.invalid_values;
    group.invalid = true;
  }
  group.values[part.slot] = value;
  group.there |= bit;
  if (group.there != group.wanted) return;

  group.there = 0;
  if (group.invalid) {
    ++counters_.samples_invalid;
    return;
  }
  ++counters_.samples;
  emit(part.kind, config_.stamp_last_frame ? t_us : group.first_us, out);
}

void CanMotionDecoder::emit(Kind kind, std::int64_t t_us, MotionSamples& out) const noexcept {
  const Group& group = groups_[kind];
  if (kind == kGyro || kind == kAccel) {
    ImuSample& sample = out.imu[out.imu_count++];
    sample = ImuSample{};
    sample.t_us = minus_delay(t_us, config_.imu_delay_us);
    sample.has_gyro = kind == kGyro;
    sample.has_accel = kind == kAccel;
    if (kind == kGyro) {
      map_axes(config_.gyro_axes, group.values, sample.gyro_rad_s);
    } else {
      map_axes(config_.accel_axes, group.values, sample.accel_m_s2);
    }
    return;
  }
  OdometrySample& sample = out.odometry[out.odometry_count++];
  sample = OdometrySample{};
  sample.t_us = minus_delay(t_us, config_.odometry_delay_us);
  if (kind == kVelocity) {
    sample.kind = OdometrySample::Kind::kBodyVelocity;
    for (int i = 0; i < 3; ++i) sample.velocity_m_s[i] = group.values[i];
    for (int i = 0; i < 6; ++i) sample.covariance_m2_s2[i] = group.values[3 + i];
    return;
  }
  sample.kind = OdometrySample::Kind::kWheelSpeed;
  double sum = 0;
  for (std::size_t i = 0; i < wheels_; ++i) sum += group.values[i];
  sample.velocity_m_s[0] = sum / static_cast<double>(wheels_);
}

}  // namespace egofocus
