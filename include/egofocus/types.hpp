// Plain data that crosses the library's border. A unit ends each name; every time is int64 microseconds in
// the host's monotonic domain (under replay: the recording's own).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/export.hpp"

namespace egofocus {

/// One brightness change. `polarity` is 1 for ON, 0 for OFF. Pixel (0, 0) is the top left one.
struct Event {
  std::int64_t t_us = 0;
  std::uint16_t x = 0;
  std::uint16_t y = 0;
  std::uint8_t polarity = 0;
};

/// One inertial sample in the body frame (x forward, y left, z up: ISO 8855), after the axis map of the
/// configuration. Gyro and accelerometer may come apart: a flag says which part is meant.
struct ImuSample {
  std::int64_t t_us = 0;
  double gyro_rad_s[3] = {0, 0, 0};
  double accel_m_s2[3] = {0, 0, 0};  ///< specific force: +9.8 along up at rest
  bool has_gyro = false;
  bool has_accel = false;
};

/// Measured translation speed of the body origin, in the body frame.
struct OdometrySample {
  enum class Kind : std::uint8_t {
    kWheelSpeed,    ///< forward speed only: velocity_m_s[0]; its variance in covariance_m2_s2[0]
    kBodyVelocity,  ///< all three components (robots without wheels, DVL, leg odometry, optical flow)
  };
  std::int64_t t_us = 0;
  double velocity_m_s[3] = {0, 0, 0};
  /// Upper triangle xx, xy, xz, yy, yz, zz. All zero means "not stated": the configured default is taken.
  double covariance_m2_s2[6] = {0, 0, 0, 0, 0, 0};
  Kind kind = Kind::kWheelSpeed;
};

/// Pose of the camera in a fixed world (p_world = R p_camera + position). Quaternion order x, y, z, w.
struct PoseSample {
  std::int64_t t_us = 0;
  double position_m[3] = {0, 0, 0};
  double orientation_xyzw[4] = {0, 0, 0, 1};
};

/// A pinhole grid: x right, y down, z forward; pixel centres at integer coordinates.
struct Intrinsics {
  std::int32_t width_px = 0;
  std::int32_t height_px = 0;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
};

/// Why a depth frame is poor or empty. A frame without a flag rests on fresh events and real parallax.
enum FrameFlag : std::uint32_t {
  kNoParallax = 1u << 0,     ///< translation too small (standstill, pure rotation): nothing can be measured
  kTooFewEvents = 1u << 1,   ///< fewer events in the window than configured
  kStaleVelocity = 1u << 2,  ///< motion samples, or a gyro's, ended too long before the tick, or contradict
  kNoMotion = 1u << 3,       ///< no ego-motion at all yet: no depth is given
  kOverload = 1u << 4,       ///< events were dropped or decimated on the way to this frame
  kLateTick = 1u << 5,       ///< the tick ran after its deadline
  kCarried = 1u << 6,  ///< not measured: the last measured depth, moved as the camera moved (CarryConfig)
};

/// One depth map. It lies on the working grid. The spans stay valid until the next call of the function that
/// returned the frame.
///
/// Inverse depth of pixel i is `inverse_depth[i] * inverse_depth_scale_per_m` in 1/m. The value 0 means
/// infinity where confidence is above 0, and "unknown" where confidence is 0.
struct DepthFrame {
  std::int64_t t_us = 0;        ///< what the frame is about: all its samples have t <= t_us
  std::int64_t age_us = 0;      ///< t_us minus the time of the newest event that a depth rests on
  std::int64_t latency_us = 0;  ///< from t_us to the moment of publication, on the engine's clock
  std::uint64_t sequence = 0;   ///< tick number, from 0
  std::uint32_t flags = 0;      ///< FrameFlag bits
  std::uint32_t events = 0;     ///< events in the window that were warped
  std::uint64_t votes = 0;      ///< votes that landed inside the grid, over all hypotheses
  Intrinsics grid;
  double inverse_depth_scale_per_m = 0;
  double parallax_px = 0;              ///< rms displacement over the grid that the last hypothesis spans
  double velocity_m_s[3] = {0, 0, 0};  ///< of the camera, in the camera frame, at t_us
  double angular_rate_rad_s[3] = {0, 0, 0};
  double velocity_sigma_m_s = 0;     ///< 1-sigma of |velocity|; the same relative error scales the depth
  std::int64_t window_begin_us = 0;  ///< events from here to t_us count; t_us where no motion was known
  /// Inverse depths tried, k * 256 * scale for k < hypotheses; 0: nothing was measured. Fused depth
  /// (CarryConfig) may be nearer.
  std::int32_t hypotheses = 0;
  std::span<const std::uint16_t> inverse_depth;  ///< [height * width], row-major
  std::span<const std::uint8_t> confidence;      ///< [height * width], 0 = no estimate, 255 = best
};

/// Metric depth in metres of one frame into `out_m` (same layout). Unknown pixels become 0; depths beyond
/// `far_m` (infinity included) become `far_m`. Writes min(out.size(), pixels) values and returns that number.
/// Thread: any. RT: yes, O(pixels).
EGOFOCUS_API std::size_t metric_depth(const DepthFrame& frame, float far_m, std::span<float> out_m) noexcept;

}  // namespace egofocus
