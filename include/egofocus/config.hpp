// What an Engine is configured with, once. Defaults are those of a 346x260 camera on a small vehicle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "egofocus/export.hpp"
#include "egofocus/types.hpp"

namespace egofocus {

enum class Distortion : std::uint8_t {
  kNone,
  kPlumbBob,     ///< k1 k2 p1 p2 k3
  kEquidistant,  ///< k1 k2 k3 k4 (fisheye)
};

/// The sensor as calibrated: pinhole and distortion of the raw pixels.
struct CameraModel {
  Intrinsics intrinsics;
  Distortion distortion = Distortion::kNone;
  double coefficients[5] = {0, 0, 0, 0, 0};
};

enum class LadderKind : std::uint8_t {
  kParallax,  ///< the last hypothesis always spans `span_px` of rms displacement over the actual window
  kMetric,    ///< the last hypothesis is 1 / z_near_m
};

/// Hypotheses are uniform in inverse depth: rho_k = k * step, rho_0 = 0 (infinity).
struct LadderConfig {
  LadderKind kind = LadderKind::kParallax;
  std::int32_t hypotheses = 64;  ///< 8..64, a multiple of 8
  double z_near_m = 2.0;         ///< nearest depth that must fit; with kParallax it limits the window's age
  double span_px = 40.0;         ///< kParallax only
  double min_parallax_px = 5.0;  ///< at z_near; below it the frame carries kNoParallax
};

struct WindowConfig {
  std::int32_t max_events = 80000;  ///< more are decimated evenly, deterministically
  std::int32_t min_events = 2000;   ///< fewer: kTooFewEvents; depth is carried, or else measured all the same
  std::int64_t max_age_us = 1000000;  ///< 1000..1000000; slow motion needs long windows for its parallax
};

struct Pixel {
  std::uint16_t x = 0;
  std::uint16_t y = 0;
};

/// The event filter. Zero switches a stage off.
struct FilterConfig {
  std::int64_t refractory_us = 0;      ///< an event this soon after the last kept one of its pixel is dropped
  std::int64_t isolated_us = 0;        ///< no neighbour (8) had an event within this time: dropped
  std::int32_t hot_pixel_rate_hz = 0;  ///< masked while above this rate over `hot_pixel_learn_us`
  std::int64_t hot_pixel_learn_us = 1000000;
  std::span<const Pixel> hot_pixels;  ///< masked from the start; read by Engine::configure() only
};

enum class MotionSource : std::uint8_t { kOdometry, kPoses };
enum class MotionModel : std::uint8_t {
  kFree,     ///< 6-dof: hand-held, drone, arm, vessel
  kWheeled,  ///< no sideways or vertical speed at the body origin (non-holonomic)
};

struct MotionConfig {
  MotionSource source = MotionSource::kOdometry;
  MotionModel model = MotionModel::kFree;
  /// p_camera = rotation * p_body + translation. Row-major. The default looks along body x.
  double camera_from_body[9] = {0, -1, 0, 0, 0, -1, 1, 0, 0};
  /// Camera centre in the body frame (lever arm).
  double camera_in_body_m[3] = {0, 0, 0};
  double gyro_noise_rad_s = 0.005;      ///< 1-sigma of one sample
  double gyro_bias_walk_rad_s2 = 1e-4;  ///< per sqrt(s)
  /// 1-sigma of one sample at rest. Stating much more than it is sees the end of a standstill late.
  double accel_noise_m_s2 = 0.15;
  double wheel_noise_m_s = 0.05;    ///< 1-sigma, quantisation included
  double wheel_scale_error = 0.02;  ///< 1-sigma, relative
  double lateral_noise_m_s = 0.05;  ///< of the non-holonomic measurement
  double max_speed_m_s = 60.0;      ///< beyond it a sample is invalid
  double max_rate_rad_s = 40.0;
  std::int64_t stale_after_us = 100000;   ///< newest motion sample older than this: kStaleVelocity
  std::int64_t max_pose_gap_us = 100000;  ///< between two poses; no track is built across a longer gap
};

/// What "in focus" means for the image of warped events I_k, over a support around each pixel. Each cost has
/// its expectation under evenly spread events taken off, and is divided by the number of events in the
/// support.
enum class FocusCost : std::uint8_t {
  kGradient,  ///< energy of the central differences of I_k (default: best on real events)
  kVariance,  ///< squared counts
  kSosa,      ///< sum of suppressed accumulations, exp(-0.4 I)
  kSoe,       ///< sum of exponentials, exp(0.1 I)
  kSti,       ///< squared time-stamp image: events of one edge share their mean time
};

struct FocusConfig {
  FocusCost cost = FocusCost::kGradient;
  /// Side of the support in cells of 2x2 pixels; odd, 3..15. The box is applied twice, which is nearly a
  /// Gaussian.
  std::int32_t support_cells = 7;
  /// Semi-global smoothing of the cost volume along 4 paths; off: argmax alone.
  bool smoothing = true;
  /// Fewer events than this in the support at the peak: no estimate.
  std::int32_t min_support_events = 8;
};

/// What a tick shows that cannot measure (no parallax, or too few events): the last depth measured with
/// enough events, seen from where the camera is now by the measured motion, with kCarried. It is right as
/// long as the world stands still. Confidence falls evenly with age, and per pixel with the camera's way over
/// its depth.
struct CarryConfig {
  std::int64_t max_age_us = 30'000'000;  ///< 0..600 s; older is not shown; 0: nothing is carried
  double max_travel = 0.5;   ///< 0.01..1; pixels nearer than the camera's way divided by this: no estimate
  double min_in_view = 0.1;  ///< 0..1; with a smaller share of the measured pixels in view: no depth at all
  /// kNetwork: a tick's depth is fused with that of the ticks before it, seen from here, whose weight falls
  /// evenly to nothing in so long; where they contradict each other the tick's own counts. 0..10 s; 0: each
  /// tick by itself. 300'000 is good where motion changes its direction (indoors, by hand); on a road errors
  /// repeat and nothing is won.
  std::int64_t fuse_us = 0;
};

/// Where depth comes from.
enum class Backend : std::uint8_t {
  kFocus,    ///< the sharpest hypothesis, classical: FocusConfig
  kNetwork,  ///< the trained network of Config::model
};

/// kNetwork where the library has a model embedded (build option EGOFOCUS_EMBED_MODEL), else kFocus. Thread:
/// any. RT: yes.
EGOFOCUS_API Backend default_backend() noexcept;

/// How a noise of so many percent is read.
enum class NoiseKind : std::uint8_t {
  kVariance,   ///< sigma^2 = percent / 100 * norm: the published words, units aside
  kDeviation,  ///< sigma = percent / 100 * norm
};

enum class NoiseDraw : std::uint8_t {
  kSample,  ///< each motion sample of a window errs on its own
  kWindow,  ///< all motion samples of a window err alike
};

/// Errors added on purpose to the motion that a tick warps with: what does a wrong velocity do to the depth?
/// The motion becomes 20 samples, evenly over the last max_age_us (or since motion is known); each component
/// of velocity and angular rate gets a zero-mean normal error. `norm` is the mean over these samples of
/// |velocity| in m/s, or |angular rate| in rad/s. The frame still tells the measured motion. For experiments:
/// off unless asked for.
struct VelocityNoise {
  double percent = 0;  ///< 0..1000; 0 leaves every byte as it is
  std::uint64_t seed = 1;
  NoiseKind kind = NoiseKind::kVariance;
  NoiseDraw draw = NoiseDraw::kSample;
};

struct RateConfig {
  double rate_hz = 20.0;         ///< 0.1..1000
  std::int64_t lateness_us = 0;  ///< tick k is about t_k and runs at t_k + lateness_us
  /// kMonotonic: a tick that could only begin this much after t_k + lateness_us gives way to the newest one
  /// that is due, so that depth is never older than this and a period; 0: however late, each tick runs.
  std::int64_t max_late_us = 0;
};

/// Capacities in samples: powers of two.
struct RingConfig {
  std::uint32_t events = 1u << 16;
  std::uint32_t imu = 1u << 10;
  std::uint32_t odometry = 1u << 10;
  std::uint32_t poses = 1u << 10;
  /// Overload: more events than this are thinned before they wait, evenly, counted by the millisecond of
  /// their own time stamps and nothing else. 0: never; else 10,000 or more, and what comes in a period and
  /// rate.lateness_us must fit into `events`.
  std::int32_t max_event_rate_hz = 0;
};

/// Applied by Engine::start() on the monotonic clock; what the system refuses is reported in Health::refused.
struct RealTimeConfig {
  std::int32_t fifo_priority =
      0;                     ///< SCHED_FIFO 1..99 for the tick and its workers; 0 leaves the scheduler alone
  std::int32_t cpu = -1;     ///< pins the tick there and worker i to cpu + i; -1 pins nothing
  bool lock_memory = false;  ///< mlockall
};

struct Config {
  CameraModel camera;
  /// Working grid; width 0 takes the camera's pinhole part as it is.
  Intrinsics grid;
  LadderConfig ladder;
  WindowConfig window;
  FilterConfig filter;
  MotionConfig motion;
  FocusConfig focus;
  CarryConfig carry;
  RateConfig rate;
  RingConfig rings;
  RealTimeConfig real_time;
  VelocityNoise velocity_noise;
  Backend backend = default_backend();
  /// kNetwork: the bytes of a model file (.efm), at a multiple of 16; read by required_arena() and
  /// configure() only. Empty: the embedded model. The ladder (but z_near_m) and window.max_events are then
  /// the model's.
  std::span<const std::byte> model;
  std::int32_t threads = 1;              ///< 1..8 workers; the bytes are the same for any number
  std::uint32_t isa_mask = 0xffffffffu;  ///< lowers the instruction sets that may be chosen (tests)
};

}  // namespace egofocus
