#include "ray_cache.hpp"

#include "pipeline/check_config.hpp"
#include "recording/replay.hpp"

namespace egofocus::training {
namespace {

std::size_t bytes_of(const std::vector<Ray>& rays) {
  return rays.size() * sizeof(Ray);
}

}  // namespace

RayCache::Key RayCache::key_of(const CameraModel& camera) {
  const Intrinsics& in = camera.intrinsics;
  const double* c = camera.coefficients;
  return {static_cast<double>(in.width_px),
          static_cast<double>(in.height_px),
          in.fx_px,
          in.fy_px,
          in.cx_px,
          in.cy_px,
          static_cast<double>(camera.distortion),
          c[0],
          c[1],
          c[2],
          c[3],
          c[4]};
}

RayCache::Rays RayCache::rays(const Config& config) {
  recording::require(check_config(config), "window");  // sizes and numbers, before they are used
  const Key key = key_of(config.camera);
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = entries_.find(key); found != entries_.end()) {
      used_.splice(used_.begin(), used_, found->second.age);
      return found->second.rays;
    }
  }
  const Intrinsics& sensor = config.camera.intrinsics;
  auto made = std::make_shared<std::vector<Ray>>(static_cast<std::size_t>(sensor.width_px) *
                                                 static_cast<std::size_t>(sensor.height_px));
  fill_rays(config.camera, *made);
  const std::lock_guard lock(mutex_);
  if (entries_.find(key) == entries_.end()) {
    used_.push_front(key);
    entries_[key] = {made, used_.begin()};
    bytes_ += bytes_of(*made);
    forget();
  }
  return made;
}

void RayCache::keep(std::size_t bytes) {
  const std::lock_guard lock(mutex_);
  most_bytes_ = bytes;
  forget();
}

void RayCache::forget() {
  while (bytes_ > most_bytes_ && used_.size() > 1) {
    const auto oldest = entries_.find(used_.back());
    bytes_ -= bytes_of(*oldest->second.rays);
    entries_.erase(oldest);
    used_.pop_back();
  }
}

}  // namespace egofocus::training
