#include "pipeline/c_convert.hpp"

namespace egofocus {
namespace {

template <typename T, std::size_t n>
void copy(const T (&from)[n], T (&to)[n]) noexcept {
  for (std::size_t i = 0; i < n; ++i) to[i] = from[i];
}

egofocus_sample_counters to_c(const SampleCounters& counters) noexcept {
  const auto& [in, ring_dropped, late, invalid, used, rejected] = counters;
  return {in, ring_dropped, late, invalid, used, rejected};
}

egofocus_event_counters to_c(const EventCounters& counters) noexcept {
  const auto& [in, ring_dropped, over_rate, out_of_range, out_of_order, ahead, late, hot_pixel, refractory,
               isolated, kept] = counters;
  return {in,   ring_dropped, over_rate,  out_of_range, out_of_order, ahead,
          late, hot_pixel,    refractory, isolated,     kept};
}

egofocus_window_counters to_c(const WindowCounters& counters) noexcept {
  const auto& [outside_motion, decimated, behind_camera] = counters;
  return {outside_motion, decimated, behind_camera};
}

egofocus_tick_counters to_c(const TickCounters& counters) noexcept {
  const auto& [run, late, skipped, no_parallax, too_few_events, stale_velocity, no_motion, carried] =
      counters;
  return {run, late, skipped, no_parallax, too_few_events, stale_velocity, no_motion, carried};
}

}  // namespace

egofocus_status status_to_c(const Status& status) noexcept {
  return {status.value(), status.bound(), status.subject(), static_cast<std::int32_t>(status.code())};
}

Status status_from_c(const egofocus_status& c) noexcept {
  return {static_cast<StatusCode>(c.code), c.subject == nullptr ? "" : c.subject, c.value, c.bound};
}

Event sample_from_c(const egofocus_event& c) noexcept {
  return {c.t_us, c.x, c.y, c.polarity};
}

ImuSample sample_from_c(const egofocus_imu_sample& c) noexcept {
  ImuSample out;
  auto& [t_us, gyro_rad_s, accel_m_s2, has_gyro, has_accel] = out;
  t_us = c.t_us;
  copy(c.gyro_rad_s, gyro_rad_s);
  copy(c.accel_m_s2, accel_m_s2);
  has_gyro = c.has_gyro != 0;
  has_accel = c.has_accel != 0;
  return out;
}

OdometrySample sample_from_c(const egofocus_odometry_sample& c) noexcept {
  OdometrySample out;
  auto& [t_us, velocity_m_s, covariance_m2_s2, kind] = out;
  t_us = c.t_us;
  copy(c.velocity_m_s, velocity_m_s);
  copy(c.covariance_m2_s2, covariance_m2_s2);
  kind = c.kind == EGOFOCUS_BODY_VELOCITY ? OdometrySample::Kind::kBodyVelocity
                                          : OdometrySample::Kind::kWheelSpeed;
  return out;
}

PoseSample sample_from_c(const egofocus_pose_sample& c) noexcept {
  PoseSample out;
  auto& [t_us, position_m, orientation_xyzw] = out;
  t_us = c.t_us;
  copy(c.position_m, position_m);
  copy(c.orientation_xyzw, orientation_xyzw);
  return out;
}

egofocus_depth_frame frame_to_c(const DepthFrame& frame) noexcept {
  const auto& [t_us, age_us, latency_us, sequence, flags, events, votes, grid, scale_per_m, parallax_px,
               velocity, rate, velocity_sigma, window_begin_us, hypotheses, inverse_depth, confidence] =
      frame;
  egofocus_depth_frame c = {};
  c.t_us = t_us, c.age_us = age_us, c.latency_us = latency_us;
  c.sequence = sequence, c.votes = votes, c.flags = flags, c.events = events;
  c.grid = {grid.width_px, grid.height_px, grid.fx_px, grid.fy_px, grid.cx_px, grid.cy_px};
  c.inverse_depth_scale_per_m = scale_per_m;
  c.parallax_px = parallax_px;
  copy(velocity, c.velocity_m_s);
  copy(rate, c.angular_rate_rad_s);
  c.velocity_sigma_m_s = velocity_sigma;
  c.window_begin_us = window_begin_us, c.hypotheses = hypotheses;
  c.inverse_depth = inverse_depth.data();
  c.confidence = confidence.data();
  return c;
}

DepthFrame pixels_from_c(const egofocus_depth_frame& c) noexcept {
  DepthFrame frame;
  if (c.grid.width_px <= 0 || c.grid.height_px <= 0 || c.inverse_depth == nullptr ||
      c.confidence == nullptr) {
    return frame;
  }
  const std::size_t pixels =
      static_cast<std::size_t>(c.grid.width_px) * static_cast<std::size_t>(c.grid.height_px);
  frame.grid.width_px = c.grid.width_px;
  frame.grid.height_px = c.grid.height_px;
  frame.inverse_depth_scale_per_m = c.inverse_depth_scale_per_m;
  frame.inverse_depth = {c.inverse_depth, pixels};
  frame.confidence = {c.confidence, pixels};
  return frame;
}

egofocus_health health_to_c(const Health& health) noexcept {
  const auto& [state, cause, events, imu, odometry, poses, window, ticks, stages, refused, sources_lost] =
      health;
  const auto& [motion_us, warp_us, input_us, backend_us, depth_us, all_us] = stages;
  return {static_cast<std::int32_t>(state),
          static_cast<std::int32_t>(cause),
          to_c(events),
          to_c(imu),
          to_c(odometry),
          to_c(poses),
          to_c(window),
          to_c(ticks),
          {motion_us, warp_us, input_us, backend_us, depth_us, all_us},
          refused,
          sources_lost};
}

}  // namespace egofocus
