// The keys of camera.toml, each once: the reader and the writer both walk this list.
// `Section` offers required(key, value), optional(key, value), choice(key, value, names), axes() and
// tables().
#pragma once

#include "recording/camera_toml.hpp"
#include "recording/toml_names.hpp"

namespace egofocus::recording {

inline constexpr Names<Distortion, 3> kDistortionNames{{{"none", Distortion::kNone},
                                                        {"plumb_bob", Distortion::kPlumbBob},
                                                        {"equidistant", Distortion::kEquidistant}}};
inline constexpr Names<LadderKind, 2> kLadderNames{
    {{"parallax", LadderKind::kParallax}, {"metric", LadderKind::kMetric}}};
inline constexpr Names<MotionSource, 2> kSourceNames{
    {{"odometry", MotionSource::kOdometry}, {"poses", MotionSource::kPoses}}};
inline constexpr Names<MotionModel, 2> kModelNames{
    {{"free", MotionModel::kFree}, {"wheeled", MotionModel::kWheeled}}};
inline constexpr Names<FocusCost, 5> kCostNames{{{"gradient", FocusCost::kGradient},
                                                 {"variance", FocusCost::kVariance},
                                                 {"sosa", FocusCost::kSosa},
                                                 {"soe", FocusCost::kSoe},
                                                 {"sti", FocusCost::kSti}}};
inline constexpr Names<std::int8_t, 6> kAxisNames{
    {{"x", 1}, {"y", 2}, {"z", 3}, {"-x", -1}, {"-y", -2}, {"-z", -3}}};

template <typename Section>
void describe_intrinsics(Section& s, Intrinsics& v) {
  s.required("width_px", v.width_px);
  s.required("height_px", v.height_px);
  s.required("fx_px", v.fx_px);
  s.required("fy_px", v.fy_px);
  s.required("cx_px", v.cx_px);
  s.required("cy_px", v.cy_px);
}

template <typename Section>
void describe(Section& s, CameraModel& v) {
  describe_intrinsics(s, v.intrinsics);
  s.choice("distortion", v.distortion, kDistortionNames);
  s.optional("coefficients", v.coefficients);
}

template <typename Section>
void describe(Section& s, Intrinsics& v) {
  describe_intrinsics(s, v);
}

template <typename Section>
void describe(Section& s, LadderConfig& v) {
  s.choice("kind", v.kind, kLadderNames);
  s.optional("hypotheses", v.hypotheses);
  s.optional("z_near_m", v.z_near_m);
  s.optional("span_px", v.span_px);
  s.optional("min_parallax_px", v.min_parallax_px);
}

template <typename Section>
void describe(Section& s, WindowConfig& v) {
  s.optional("max_events", v.max_events);
  s.optional("min_events", v.min_events);
  s.optional("max_age_us", v.max_age_us);
}

template <typename Section>
void describe(Section& s, FilterConfig& v) {
  s.optional("refractory_us", v.refractory_us);
  s.optional("isolated_us", v.isolated_us);
  s.optional("hot_pixel_rate_hz", v.hot_pixel_rate_hz);
  s.optional("hot_pixel_learn_us", v.hot_pixel_learn_us);
}

template <typename Section>
void describe(Section& s, MotionConfig& v) {
  s.choice("source", v.source, kSourceNames);
  s.choice("model", v.model, kModelNames);
  s.optional("camera_from_body", v.camera_from_body);
  s.optional("camera_in_body_m", v.camera_in_body_m);
  s.optional("gyro_noise_rad_s", v.gyro_noise_rad_s);
  s.optional("gyro_bias_walk_rad_s2", v.gyro_bias_walk_rad_s2);
  s.optional("accel_noise_m_s2", v.accel_noise_m_s2);
  s.optional("wheel_noise_m_s", v.wheel_noise_m_s);
  s.optional("wheel_scale_error", v.wheel_scale_error);
  s.optional("lateral_noise_m_s", v.lateral_noise_m_s);
  s.optional("max_speed_m_s", v.max_speed_m_s);
  s.optional("max_rate_rad_s", v.max_rate_rad_s);
  s.optional("stale_after_us", v.stale_after_us);
  s.optional("max_pose_gap_us", v.max_pose_gap_us);
}

template <typename Section>
void describe(Section& s, FocusConfig& v) {
  s.choice("cost", v.cost, kCostNames);
  s.optional("support_cells", v.support_cells);
  s.optional("smoothing", v.smoothing);
  s.optional("min_support_events", v.min_support_events);
}

template <typename Section>
void describe(Section& s, CarryConfig& v) {
  s.optional("max_age_us", v.max_age_us);
  s.optional("max_travel", v.max_travel);
  s.optional("min_in_view", v.min_in_view);
  s.optional("fuse_us", v.fuse_us);
}

template <typename Section>
void describe(Section& s, RateConfig& v) {
  s.optional("rate_hz", v.rate_hz);
  s.optional("lateness_us", v.lateness_us);
  s.optional("max_late_us", v.max_late_us);
}

template <typename Section>
void describe(Section& s, RingConfig& v) {
  s.optional("events", v.events);
  s.optional("imu", v.imu);
  s.optional("odometry", v.odometry);
  s.optional("poses", v.poses);
  s.optional("max_event_rate_hz", v.max_event_rate_hz);
}

inline const char* unit_name(CanUnit unit) noexcept {
  constexpr const char* kNames[] = {"si", "deg/s", "g", "km/h"};
  return kNames[static_cast<std::size_t>(unit)];
}
inline const char* role_name(CanRole role) noexcept {
  return to_string(role);
}

template <typename Section>
void describe(Section& s, CanSignalRole& v) {
  s.name("message", v.message);
  s.name("signal", v.signal);
  s.required_named("role", v.role, can_role_of, role_name, kCanRoles);
  s.named("unit", v.unit, can_unit_of, unit_name, 4);
  s.optional("scale", v.scale);
  s.optional("offset", v.offset);
  s.limit("raw_max", v.raw_max);
}

/// The truth's unit is a plain number in CameraFile; a section needs a type of its own.
struct DepthSection {
  double& scale_m;
};

template <typename Section>
void describe(Section& s, DepthSection& v) {
  s.optional("scale_m", v.scale_m);
}

template <typename Section>
void describe(Section& s, CanSetup& v) {
  s.required("dbc", v.dbc);
  s.axes("gyro_axes", v.motion.gyro_axes, kAxisNames);
  s.axes("accel_axes", v.motion.accel_axes, kAxisNames);
  s.optional("group_window_us", v.motion.group_window_us);
  s.optional("stamp_last_frame", v.motion.stamp_last_frame);
  s.optional("imu_delay_us", v.motion.imu_delay_us);
  s.optional("odometry_delay_us", v.motion.odometry_delay_us);
  s.optional("match_parameter_group", v.motion.match_parameter_group);
  s.tables("signals", v.motion.signals, v.motion.signal_count);
}

inline constexpr Names<UsbSensitivity, 5> kSensitivityNames{{{"very_low", UsbSensitivity::kVeryLow},
                                                             {"low", UsbSensitivity::kLow},
                                                             {"default", UsbSensitivity::kDefault},
                                                             {"high", UsbSensitivity::kHigh},
                                                             {"very_high", UsbSensitivity::kVeryHigh}}};

template <typename Section>
void describe(Section& s, UsbSetup& v) {
  describe_usb(s, v, kAxisNames, kSensitivityNames);
}

/// `File` offers section(name, value).
template <typename File>
void describe_file(File& file, CameraFile& v) {
  file.section("camera", v.config.camera);
  file.section("grid", v.config.grid);
  file.section("ladder", v.config.ladder);
  file.section("window", v.config.window);
  file.section("filter", v.config.filter);
  file.section("motion", v.config.motion);
  file.section("focus", v.config.focus);
  file.section("carry", v.config.carry);
  file.section("rate", v.config.rate);
  file.section("rings", v.config.rings);
  DepthSection depth{v.depth_scale_m};
  file.section("depth", depth);
  file.section("can", v.can);
  file.section("usb", v.usb);
  file.section("v4l2", v.v4l2);
}

}  // namespace egofocus::recording
