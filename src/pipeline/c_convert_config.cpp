#include <type_traits>

#include "pipeline/c_convert.hpp"

namespace egofocus {
namespace {

template <typename T, std::size_t n>
void copy(const T (&from)[n], T (&to)[n]) noexcept {
  for (std::size_t i = 0; i < n; ++i) to[i] = from[i];
}

template <typename Enum>
std::int32_t number(Enum value) noexcept {
  return static_cast<std::int32_t>(value);
}

Intrinsics from_c(const egofocus_intrinsics& c) noexcept {
  Intrinsics out;
  auto& [width_px, height_px, fx_px, fy_px, cx_px, cy_px] = out;
  width_px = c.width_px, height_px = c.height_px;
  fx_px = c.fx_px, fy_px = c.fy_px, cx_px = c.cx_px, cy_px = c.cy_px;
  return out;
}

egofocus_intrinsics to_c(const Intrinsics& in) noexcept {
  const auto& [width_px, height_px, fx_px, fy_px, cx_px, cy_px] = in;
  return {width_px, height_px, fx_px, fy_px, cx_px, cy_px};
}

CameraModel from_c(const egofocus_camera& c) noexcept {
  CameraModel out;
  auto& [intrinsics, distortion, coefficients] = out;
  intrinsics = from_c(c.intrinsics);
  distortion = static_cast<Distortion>(c.distortion);
  copy(c.coefficients, coefficients);
  return out;
}

egofocus_camera to_c(const CameraModel& in) noexcept {
  const auto& [intrinsics, distortion, coefficients] = in;
  egofocus_camera c = {to_c(intrinsics), {}, number(distortion)};
  copy(coefficients, c.coefficients);
  return c;
}

LadderConfig from_c(const egofocus_ladder& c) noexcept {
  LadderConfig out;
  auto& [kind, hypotheses, z_near_m, span_px, min_parallax_px] = out;
  kind = static_cast<LadderKind>(c.kind);
  hypotheses = c.hypotheses;
  z_near_m = c.z_near_m, span_px = c.span_px, min_parallax_px = c.min_parallax_px;
  return out;
}

egofocus_ladder to_c(const LadderConfig& in) noexcept {
  const auto& [kind, hypotheses, z_near_m, span_px, min_parallax_px] = in;
  return {number(kind), hypotheses, z_near_m, span_px, min_parallax_px};
}

WindowConfig from_c(const egofocus_window& c) noexcept {
  WindowConfig out;
  auto& [max_events, min_events, max_age_us] = out;
  max_events = c.max_events, min_events = c.min_events, max_age_us = c.max_age_us;
  return out;
}

egofocus_window to_c(const WindowConfig& in) noexcept {
  const auto& [max_events, min_events, max_age_us] = in;
  return {max_events, min_events, max_age_us};
}

// Both are two uint16; the array is read once, by configure(), which was compiled apart from whatever wrote
// it.
static_assert(sizeof(Pixel) == sizeof(egofocus_pixel) && alignof(Pixel) == alignof(egofocus_pixel));
static_assert(offsetof(Pixel, y) == offsetof(egofocus_pixel, y));

FilterConfig from_c(const egofocus_filter& c) noexcept {
  FilterConfig out;
  auto& [refractory_us, isolated_us, hot_pixel_rate_hz, hot_pixel_learn_us, hot_pixels] = out;
  refractory_us = c.refractory_us, isolated_us = c.isolated_us;
  hot_pixel_rate_hz = c.hot_pixel_rate_hz, hot_pixel_learn_us = c.hot_pixel_learn_us;
  hot_pixels = {reinterpret_cast<const Pixel*>(c.hot_pixels), c.hot_pixel_count};
  return out;
}

egofocus_filter to_c(const FilterConfig& in) noexcept {
  const auto& [refractory_us, isolated_us, hot_pixel_rate_hz, hot_pixel_learn_us, hot_pixels] = in;
  return {refractory_us,
          isolated_us,
          hot_pixel_learn_us,
          hot_pixel_rate_hz,
          static_cast<std::uint32_t>(hot_pixels.size()),
          reinterpret_cast<const egofocus_pixel*>(hot_pixels.data())};
}

MotionConfig from_c(const egofocus_motion& c) noexcept {
  MotionConfig out;
  auto& [source, model, camera_from_body, camera_in_body_m, gyro_noise, gyro_walk, accel_noise, wheel_noise,
         wheel_scale, lateral_noise, max_speed, max_rate, stale_after_us, max_pose_gap_us] = out;
  source = static_cast<MotionSource>(c.source);
  model = static_cast<MotionModel>(c.model);
  copy(c.camera_from_body, camera_from_body);
  copy(c.camera_in_body_m, camera_in_body_m);
  gyro_noise = c.gyro_noise_rad_s, gyro_walk = c.gyro_bias_walk_rad_s2, accel_noise = c.accel_noise_m_s2;
  wheel_noise = c.wheel_noise_m_s, wheel_scale = c.wheel_scale_error, lateral_noise = c.lateral_noise_m_s;
  max_speed = c.max_speed_m_s, max_rate = c.max_rate_rad_s;
  stale_after_us = c.stale_after_us, max_pose_gap_us = c.max_pose_gap_us;
  return out;
}

egofocus_motion to_c(const MotionConfig& in) noexcept {
  const auto& [source, model, camera_from_body, camera_in_body_m, gyro_noise, gyro_walk, accel_noise,
               wheel_noise, wheel_scale, lateral_noise, max_speed, max_rate, stale_after_us,
               max_pose_gap_us] = in;
  egofocus_motion c = {number(source), number(model),  {},          {},
                       gyro_noise,     gyro_walk,      accel_noise, wheel_noise,
                       wheel_scale,    lateral_noise,  max_speed,   max_rate,
                       stale_after_us, max_pose_gap_us};
  copy(camera_from_body, c.camera_from_body);
  copy(camera_in_body_m, c.camera_in_body_m);
  return c;
}

FocusConfig from_c(const egofocus_focus& c) noexcept {
  FocusConfig out;
  auto& [cost, support_cells, smoothing, min_support_events] = out;
  cost = static_cast<FocusCost>(c.cost);
  support_cells = c.support_cells;
  smoothing = c.smoothing != 0;
  min_support_events = c.min_support_events;
  return out;
}

egofocus_focus to_c(const FocusConfig& in) noexcept {
  const auto& [cost, support_cells, smoothing, min_support_events] = in;
  return {number(cost), support_cells, smoothing ? 1 : 0, min_support_events};
}

CarryConfig from_c(const egofocus_carry& c) noexcept {
  CarryConfig out;
  auto& [max_age_us, max_travel, min_in_view, fuse_us] = out;
  max_age_us = c.max_age_us, max_travel = c.max_travel, min_in_view = c.min_in_view, fuse_us = c.fuse_us;
  return out;
}

egofocus_carry to_c(const CarryConfig& in) noexcept {
  const auto& [max_age_us, max_travel, min_in_view, fuse_us] = in;
  return {max_age_us, max_travel, min_in_view, fuse_us};
}

RateConfig from_c(const egofocus_rate& c) noexcept {
  RateConfig out;
  auto& [rate_hz, lateness_us, max_late_us] = out;
  rate_hz = c.rate_hz, lateness_us = c.lateness_us, max_late_us = c.max_late_us;
  return out;
}

egofocus_rate to_c(const RateConfig& in) noexcept {
  const auto& [rate_hz, lateness_us, max_late_us] = in;
  return {rate_hz, lateness_us, max_late_us};
}

RingConfig from_c(const egofocus_rings& c) noexcept {
  RingConfig out;
  auto& [events, imu, odometry, poses, max_event_rate_hz] = out;
  events = c.events, imu = c.imu, odometry = c.odometry, poses = c.poses;
  max_event_rate_hz = c.max_event_rate_hz;
  return out;
}

egofocus_rings to_c(const RingConfig& in) noexcept {
  const auto& [events, imu, odometry, poses, max_event_rate_hz] = in;
  return {events, imu, odometry, poses, max_event_rate_hz};
}

RealTimeConfig from_c(const egofocus_real_time& c) noexcept {
  RealTimeConfig out;
  auto& [fifo_priority, cpu, lock_memory] = out;
  fifo_priority = c.fifo_priority, cpu = c.cpu, lock_memory = c.lock_memory != 0;
  return out;
}

egofocus_real_time to_c(const RealTimeConfig& in) noexcept {
  const auto& [fifo_priority, cpu, lock_memory] = in;
  return {fifo_priority, cpu, lock_memory ? 1 : 0};
}

VelocityNoise from_c(const egofocus_velocity_noise& c) noexcept {
  VelocityNoise out;
  auto& [percent, seed, kind, draw] = out;
  percent = c.percent, seed = c.seed;
  kind = static_cast<NoiseKind>(c.kind);
  draw = static_cast<NoiseDraw>(c.draw);
  return out;
}

egofocus_velocity_noise to_c(const VelocityNoise& in) noexcept {
  const auto& [percent, seed, kind, draw] = in;
  return {percent, seed, number(kind), number(draw)};
}

template <typename Enum>
bool known(std::int32_t value, Enum last) noexcept {
  return value >= 0 && value <= number(last);
}

}  // namespace

Status c_config_problem(const egofocus_config& c) noexcept {
  if (!known(c.camera.distortion, Distortion::kEquidistant)) {
    return {StatusCode::kBadDistortion, "camera.distortion", c.camera.distortion};
  }
  if (!known(c.ladder.kind, LadderKind::kMetric))
    return {StatusCode::kBadLadder, "ladder.kind", c.ladder.kind};
  if (!known(c.motion.source, MotionSource::kPoses)) {
    return {StatusCode::kBadMotion, "motion.source", c.motion.source};
  }
  if (!known(c.motion.model, MotionModel::kWheeled)) {
    return {StatusCode::kBadMotion, "motion.model", c.motion.model};
  }
  if (!known(c.focus.cost, FocusCost::kSti)) return {StatusCode::kBadFocus, "focus.cost", c.focus.cost};
  if (!known(c.velocity_noise.kind, NoiseKind::kDeviation)) {
    return {StatusCode::kBadMotion, "velocity_noise.kind", c.velocity_noise.kind};
  }
  if (!known(c.velocity_noise.draw, NoiseDraw::kWindow)) {
    return {StatusCode::kBadMotion, "velocity_noise.draw", c.velocity_noise.draw};
  }
  if (!known(c.backend, Backend::kNetwork)) return {StatusCode::kBadFocus, "backend", c.backend};
  if (c.model == nullptr && c.model_bytes != 0) return {StatusCode::kBadModel, "model is NULL"};
  if (c.filter.hot_pixels == nullptr && c.filter.hot_pixel_count != 0) {
    return {StatusCode::kBadFilter, "filter.hot_pixels", 0};
  }
  return {};
}

Config config_from_c(const egofocus_config& c) noexcept {
  Config out;
  auto& [camera, grid, ladder, window, filter, motion, focus, carry, rate, rings, real_time, velocity_noise,
         backend, model, threads, isa_mask] = out;
  camera = from_c(c.camera);
  grid = from_c(c.grid);
  ladder = from_c(c.ladder);
  window = from_c(c.window);
  filter = from_c(c.filter);
  motion = from_c(c.motion);
  focus = from_c(c.focus);
  carry = from_c(c.carry);
  rate = from_c(c.rate);
  rings = from_c(c.rings);
  real_time = from_c(c.real_time);
  velocity_noise = from_c(c.velocity_noise);
  backend = static_cast<Backend>(c.backend);
  model = {static_cast<const std::byte*>(c.model), c.model_bytes};
  threads = c.threads;
  isa_mask = c.isa_mask;
  return out;
}

egofocus_config config_to_c(const Config& config) noexcept {
  const auto& [camera, grid, ladder, window, filter, motion, focus, carry, rate, rings, real_time,
               velocity_noise, backend, model, threads, isa_mask] = config;
  return {to_c(camera),    to_c(grid),  to_c(ladder), to_c(window), to_c(filter),    to_c(motion),
          to_c(focus),     to_c(carry), to_c(rate),   to_c(rings),  to_c(real_time), to_c(velocity_noise),
          number(backend), threads,     isa_mask,     model.data(), model.size()};
}

}  // namespace egofocus
