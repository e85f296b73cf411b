#include "recording/recording_builder.hpp"

#include <algorithm>
#include <cmath>

#include "pipeline/working_grid.hpp"
#include "recording/error.hpp"
#include "recording/folder.hpp"
#include "recording/mapped_file.hpp"
#include "recording/png_io.hpp"
#include "recording/pose_file.hpp"
#include "recording/replay.hpp"
#include "recording/text_file.hpp"

namespace egofocus::recording {
namespace {

constexpr std::int64_t kHourUs = 3600LL * 1000000;
constexpr std::int64_t kFarthestUs = std::int64_t{1} << 60;
// EVT3 counts time in 24 bits; silences cost a word per 4.2 s. No sensor is silent for a week.
constexpr std::int64_t kLongestSilenceUs = 7 * 24 * kHourUs;
constexpr std::uint16_t kMaxSidePx = 2048;  // EVT3 addresses have 11 bits

bool possible(std::int64_t t_us) {
  return t_us > -kFarthestUs && t_us < kFarthestUs;
}

bool all_finite(const float (&values)[3]) {
  return std::all_of(values, values + 3, [](float v) { return std::isfinite(v); });
}

}  // namespace

RecordingBuilder::RecordingBuilder(const std::filesystem::path& output, const ConvertOptions& options)
    : folder_(output), wanted_t0_us_(options.t0_us), wanted_size_(options.size) {
  camera.config.ladder.z_near_m = options.z_near_m;
  camera.config.motion.source = MotionSource::kPoses;
}

void RecordingBuilder::set_camera(const CameraModel& model, const std::string& where) {
  const Intrinsics& in = model.intrinsics;
  if (in.width_px < 1 || in.height_px < 1 || in.width_px > kMaxSidePx || in.height_px > kMaxSidePx) {
    throw Error(ExitCode::kUsage, where, "at most 2048x2048 px fit into events.raw.");
  }
  if (wanted_size_ && (wanted_size_->width_px != in.width_px || wanted_size_->height_px != in.height_px)) {
    throw Error(ExitCode::kUsage, "--size",
                "contradicts " + where + ", which says " + std::to_string(in.width_px) + "x" +
                    std::to_string(in.height_px) + " px. Leave it out.");
  }
  camera.config.camera = model;
  camera.config.grid = in;
  require(check_camera(camera.config), where);
  report.size = {static_cast<std::uint16_t>(in.width_px), static_cast<std::uint16_t>(in.height_px)};
}

void RecordingBuilder::add_poses(std::span<const PoseSample> poses) {
  for (const PoseSample& pose : poses) {
    if (!possible(pose.t_us) || (!poses_.empty() && pose.t_us <= poses_.back().t_us)) {
      ++report.poses_dropped;
    } else {
      poses_.push_back(pose);
    }
  }
}

void RecordingBuilder::read_poses(const std::filesystem::path& path) {
  poses_.clear();
  add_poses(parse_poses(MappedFile(path).text(), path.string()));
}

void RecordingBuilder::start(std::int64_t first_event_us) {
  report.t0_us = wanted_t0_us_.value_or(first_event_us > kHourUs ? first_event_us / 1000000 * 1000000 : 0);
  folder_.create();
  events_.emplace(folder_ / "events.raw", report.size);
}

bool RecordingBuilder::keep(Event& event) {
  event.t_us -= report.t0_us;
  if (event.t_us < 0) {
    ++report.before_t0;
  } else if (event.x >= report.size.width_px || event.y >= report.size.height_px) {
    ++report.out_of_range;
  } else if (report.events > 0 && event.t_us < report.last_us) {
    ++report.out_of_order;
  } else if (event.t_us - report.last_us > kLongestSilenceUs) {
    ++report.malformed;
  } else {
    return true;
  }
  return false;
}

void RecordingBuilder::add_events(std::span<const Event> events) {
  kept_.clear();
  for (Event event : events) {
    if (!possible(event.t_us)) {
      ++report.malformed;
      continue;
    }
    if (!events_) start(event.t_us);
    if (!poses_.empty()) {
      report.events_before_poses += event.t_us < poses_.front().t_us ? 1 : 0;
      report.events_after_poses += event.t_us > poses_.back().t_us ? 1 : 0;
    }
    if (!keep(event)) continue;
    if (report.events == 0) report.first_us = event.t_us;
    report.last_us = event.t_us;
    ++report.events;
    kept_.push_back(event);
  }
  if (events_) events_->write(kept_);
}

void RecordingBuilder::add_imu(const ImuReading& reading) {
  ImuReading moved = reading;
  moved.t_us = possible(reading.t_us) ? reading.t_us - report.t0_us : -1;
  if (!events_ || moved.t_us <= last_imu_us_ || !all_finite(reading.gyro) || !all_finite(reading.accel)) {
    ++report.imu_dropped;
    return;
  }
  if (!imu_) imu_.emplace(folder_ / "can.log");
  imu_->write(moved);
  last_imu_us_ = moved.t_us;
  ++report.imu_samples;
}

void RecordingBuilder::add_depth(std::int64_t t_us, const Picture<float>& depth_m) {
  const std::int64_t moved_us = possible(t_us) ? t_us - report.t0_us : -1;
  if (!events_ || moved_us <= last_depth_us_) {
    ++report.depth_dropped;
    return;
  }
  last_depth_us_ = moved_us;
  Grey16Picture picture(depth_m.width_px, depth_m.height_px);
  for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
    const double units = std::nearbyint(static_cast<double>(depth_m.pixels[i]) / camera.depth_scale_m);
    if (!(units >= 1)) continue;
    if (units > 65535) {
      ++report.depth_out_of_scale;
    } else {
      picture.pixels[i] = static_cast<std::uint16_t>(units);
    }
  }
  if (report.depth_pictures == 0) std::filesystem::create_directory(folder_ / "depth");
  write_png(folder_ / depth_name(moved_us), picture);
  ++report.depth_pictures;
}

void RecordingBuilder::write_motion() {
  if (imu_) {
    imu_->close();
    write_text_file(folder_ / kImuDbcName, imu_dbc_text());
    if (poses_.empty()) camera.config.motion.source = MotionSource::kOdometry;
  } else {
    camera.can = {};
  }
  if (poses_.empty()) return;
  for (PoseSample& pose : poses_) pose.t_us -= report.t0_us;
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    report.widest_pose_gap_us = std::max(report.widest_pose_gap_us, poses_[i].t_us - poses_[i - 1].t_us);
  }
  report.poses = poses_.size();
  write_text_file(folder_ / "poses.txt", poses_text(poses_));
}

ConvertReport RecordingBuilder::finish(const std::string& where) {
  if (!events_ || report.events == 0) {
    throw Error(ExitCode::kNoEvents, where,
                "has no event inside the sensor after --t0 (" + std::to_string(report.malformed) +
                    " malformed, " + std::to_string(report.out_of_range) + " outside, " +
                    std::to_string(report.before_t0) + " before). Is it the right file?");
  }
  events_->close();
  write_motion();
  if (report.poses == 0) {
    report.remarks.emplace_back(
        imu_ ? "No poses, and an IMU without velocity: a replay gives no depth until poses (--poses) or a "
               "velocity on the bus are added."
             : "No motion: a replay needs poses. Convert again with --poses FILE, or add poses.txt.");
  } else if (report.widest_pose_gap_us > camera.config.motion.max_pose_gap_us) {
    report.remarks.emplace_back("A gap between poses is wider than [motion] max_pose_gap_us in camera.toml.");
  }
  write_camera_toml(folder_ / "camera.toml", camera);
  folder_.finish();
  return report;
}

}  // namespace egofocus::recording
