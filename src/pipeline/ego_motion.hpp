// Ego-motion: samples of IMU and odometry, or poses, in; the camera's motion during a window out.
//
// Causal, and a function of the samples' times alone: add() only sorts, advance(t) uses what has t_us <= t.
// The order of arrival does not matter as long as a sample comes before the advance() that passes its time;
// after it, it is late. Fixed-size: the object is some two hundred kilobytes and belongs into the arena.
#pragma once

#include <cstdint>
#include <span>
#include <variant>

#include "egofocus/config.hpp"
#include "egofocus/health.hpp"
#include "egofocus/status.hpp"
#include "egofocus/types.hpp"
#include "pipeline/motion_history.hpp"
#include "pipeline/motion_track.hpp"
#include "pipeline/pose_history.hpp"
#include "pipeline/sort_buffer.hpp"
#include "pipeline/velocity_filter.hpp"

namespace egofocus {

/// Thread: one. RT: yes, all but check(); add() O(1) for samples nearly in order, advance() O(samples).
class EgoMotion {
 public:
  /// Samples of one kind that may wait for advance(). One more, and the oldest are used early.
  static constexpr std::uint32_t kPending = 512;
  static constexpr int kMaxSamples = 20;
  /// Without any motion sample for this long there is no motion: track() says false.
  static constexpr std::int64_t kMaxHold_us = 1000000;

  /// kBadMotion with the field's name: extrinsics not orthonormal, a noise or limit that is not positive and
  /// finite. Thread: any. RT: no.
  static Status check(const MotionConfig& config) noexcept;

  /// Precondition: check(config) is ok.
  explicit EgoMotion(const MotionConfig& config) noexcept;
  EgoMotion(const EgoMotion&) = delete;
  EgoMotion& operator=(const EgoMotion&) = delete;

  /// Samples of the source that is not configured are counted as `in` and otherwise ignored. Not finite or
  /// implausible: `invalid`. At or before the last advance(): `late`.
  void add(const ImuSample& sample) noexcept;
  void add(const OdometrySample& sample) noexcept;
  void add(const PoseSample& sample) noexcept;

  /// Uses all samples with t <= t_us, in order of time. Never goes back.
  void advance(std::int64_t t_us) noexcept;

  /// Motion is known from here on; INT64_MAX: not at all.
  [[nodiscard]] std::int64_t earliest_us() const noexcept;
  /// Time of the newest sample used that says how the camera moves; INT64_MIN: none.
  [[nodiscard]] std::int64_t newest_us() const noexcept;

  /// The motion at t_us rests on samples older than config.stale_after_us, on some of the sensors alone, or
  /// on sensors that contradict each other: VelocityFilter::doubts().
  [[nodiscard]] bool is_stale(std::int64_t t_us) const noexcept;

  /// False: begin_us < earliest_us(), a gap between two poses of the window is longer than allowed, or the
  /// newest sample is older than kMaxHold_us; `out` is then untouched. Precondition: begin_us <= end_us.
  bool track(std::int64_t begin_us, std::int64_t end_us, MotionTrack& out) const noexcept;

  /// min(kMaxSamples, out.size()) samples, evenly from begin_us to end_us, newest last; 0 where track() says
  /// false.
  int samples(std::int64_t begin_us, std::int64_t end_us, std::span<MotionSample> out) const noexcept;

  /// The motion at t_us; beyond the newest sample the last one, held. Zero where motion is not known.
  [[nodiscard]] CameraMotion at_end(std::int64_t t_us) const noexcept;

  [[nodiscard]] const SampleCounters& imu_counters() const noexcept { return imu_counters_; }
  [[nodiscard]] const SampleCounters& odometry_counters() const noexcept { return odometry_counters_; }
  [[nodiscard]] const SampleCounters& pose_counters() const noexcept { return pose_counters_; }

  /// For tests and logs. Precondition: MotionSource::kOdometry.
  [[nodiscard]] const VelocityFilter& filter() const noexcept { return std::get_if<Odometric>(&of_)->filter; }

 private:
  /// What each kind of source needs.
  struct Odometric {
    explicit Odometric(const MotionConfig& config) noexcept : filter(config) {}
    void remember(std::int64_t t_us, bool new_rate) noexcept;
    SortBuffer<ImuSample, kPending> imu;
    SortBuffer<OdometrySample, kPending> odometry;
    VelocityFilter filter;
    MotionHistory history;
    std::int64_t used_us = INT64_MIN;  // the newest sample that the history rests on
  };
  struct Posed {
    explicit Posed(const MotionConfig& config) noexcept : history(config) {}
    SortBuffer<PoseSample, kPending> poses;
    PoseHistory history;
  };

  [[nodiscard]] bool known(std::int64_t begin_us, std::int64_t end_us) const noexcept;
  void use(Odometric& of, const ImuSample& sample) noexcept;
  void use(Odometric& of, const OdometrySample& sample) noexcept;
  void use(Posed& of, const PoseSample& sample) noexcept;
  template <typename Sample>
  void wait(const Sample& sample, bool plausible, SortBuffer<Sample, kPending>& pending,
            SampleCounters& counters) noexcept;

  MotionConfig config_;
  std::int64_t horizon_us_ = INT64_MIN;  // the last advance()
  SampleCounters imu_counters_;
  SampleCounters odometry_counters_;
  SampleCounters pose_counters_;
  std::variant<Odometric, Posed> of_;
};

}  // namespace egofocus
