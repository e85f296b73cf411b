#include "recording/rotation_from_events.hpp"

#include <algorithm>

namespace egofocus::recording {
namespace {

constexpr double kFirstStep = 0.64;  // rad/s
constexpr double kLastStep = 0.01;
// About the optical axis a rate moves pixels less: steps are as much longer.
constexpr double kStepOfAxis[3] = {1, 1, 3};
constexpr double kCellOfStep = 4;  // px per rad/s
// A pixel that never rests (hot, or a lamp) would else pull towards no rotation at all.
constexpr std::uint8_t kMostCounts = 8;

}  // namespace

RotationFromEvents::RotationFromEvents(const CameraModel& camera)
    : camera_(camera.intrinsics),
      rays_(static_cast<std::size_t>(camera_.width_px) * static_cast<std::size_t>(camera_.height_px)),
      counts_(rays_.size()) {
  fill_rays(camera, rays_);
}

bool RotationFromEvents::estimate(std::span<const Event> events, std::int64_t t_us, Rate& rate) {
  if (events.size() < kFewestEvents) return false;
  seen_.clear();
  const std::size_t step = events.size() / kMostEvents + 1;
  for (std::size_t i = 0; i < events.size(); i += step) {
    const Event& event = events[i];
    if (event.x >= camera_.width_px || event.y >= camera_.height_px) continue;
    const Ray ray =
        rays_[static_cast<std::size_t>(event.y) * static_cast<std::size_t>(camera_.width_px) + event.x];
    if (ray.x >= kNoRay) continue;
    seen_.push_back({ray.x, ray.y, static_cast<float>(event.t_us - t_us) * 1e-6f});
  }
  if (seen_.size() < kFewestEvents) return false;

  // From the last rate, or from rest where that is better.
  Rate other{0, 0, 0};
  const double own = climb(last_);
  if (climb(other) > own) last_ = other;
  rate = last_;
  return true;
}

// Pattern search: along each axis while it helps, then with half the step. Long steps look at large cells,
// where the hill is wide.
double RotationFromEvents::climb(Rate& rate) {
  double best = 0;
  for (double width = kFirstStep; width >= kLastStep; width /= 2) {
    cell_px_ = static_cast<float>(std::max(1.0, width * kCellOfStep));
    best = focus(rate);
    for (bool moved = true; moved;) {
      moved = false;
      for (const std::size_t axis : {1u, 0u, 2u}) {
        for (const double by : {width, -width}) {
          Rate tried = rate;
          tried[axis] += by * kStepOfAxis[axis];
          const double value = focus(tried);
          if (value <= best) continue;
          best = value;
          rate = tried;
          moved = true;
          break;
        }
      }
    }
  }
  return best;
}

// Sum of squared counts of the events, turned back to the middle of the window. The motion field of a
// rotation is that of Longuet-Higgins and Prazdny, "The interpretation of a moving retinal image", 1980.
double RotationFromEvents::focus(const Rate& rate) {
  std::fill(counts_.begin(), counts_.end(), std::uint8_t{0});
  const auto wx = static_cast<float>(rate[0]);
  const auto wy = static_cast<float>(rate[1]);
  const auto wz = static_cast<float>(rate[2]);
  const auto fx = static_cast<float>(camera_.fx_px) / cell_px_;
  const auto fy = static_cast<float>(camera_.fy_px) / cell_px_;
  const float cx = (static_cast<float>(camera_.cx_px) + 0.5f) / cell_px_;
  const float cy = (static_cast<float>(camera_.cy_px) + 0.5f) / cell_px_;
  const float width = static_cast<float>(camera_.width_px) / cell_px_;
  const float height = static_cast<float>(camera_.height_px) / cell_px_;
  std::uint32_t sum = 0;
  for (const Seen& e : seen_) {
    const float flow_x = e.x * e.y * wx - (1 + e.x * e.x) * wy + e.y * wz;
    const float flow_y = (1 + e.y * e.y) * wx - e.x * e.y * wy - e.x * wz;
    const float u = fx * (e.x - flow_x * e.dt_s) + cx;
    const float v = fy * (e.y - flow_y * e.dt_s) + cy;
    if (!(u >= 0) || !(v >= 0) || u >= width || v >= height) continue;
    std::uint8_t& count = counts_[static_cast<std::size_t>(v) * static_cast<std::size_t>(camera_.width_px) +
                                  static_cast<std::size_t>(u)];
    if (count == kMostCounts) continue;
    sum += 2u * count + 1;
    ++count;
  }
  return sum;
}

}  // namespace egofocus::recording
