#include "pipeline/check_config.hpp"

#include "core/worker_pool.hpp"
#include "pipeline/carried_depth.hpp"
#include "pipeline/ego_motion.hpp"
#include "pipeline/event_filter.hpp"
#include "pipeline/event_window.hpp"
#include "pipeline/focus_cost.hpp"
#include "pipeline/hypothesis_ladder.hpp"
#include "pipeline/scheduler.hpp"
#include "pipeline/velocity_noise.hpp"
#include "pipeline/working_grid.hpp"

namespace egofocus {
namespace {

Status check_rings(const RingConfig& rings) noexcept {
  const struct {
    const char* name;
    std::uint32_t capacity;
  } all[] = {{"rings.events", rings.events},
             {"rings.imu", rings.imu},
             {"rings.odometry", rings.odometry},
             {"rings.poses", rings.poses}};
  for (const auto& ring : all) {
    const bool power_of_two = (ring.capacity & (ring.capacity - 1)) == 0;
    if (!power_of_two || ring.capacity < 64 || ring.capacity > (1u << 24))
      return {StatusCode::kBadRing, ring.name, ring.capacity};
  }
  return {};
}

Status check_event_rate(const Config& config) noexcept {
  const std::int32_t most_hz = config.rings.max_event_rate_hz;
  if (most_hz == 0) return {};
  if (most_hz < 10'000)
    return {StatusCode::kBadRing, "rings.max_event_rate_hz (0, or 10000 and more)", most_hz, 10'000};
  const double wait_s = 1.0 / config.rate.rate_hz + static_cast<double>(config.rate.lateness_us) * 1e-6;
  if (most_hz * wait_s > config.rings.events) {
    return {StatusCode::kBadRing,
            "rings.events is too small for max_event_rate_hz over a period and lateness_us",
            config.rings.events, static_cast<std::int64_t>(most_hz * wait_s)};
  }
  return {};
}

Status check_threads(const Config& config) noexcept {
  if (config.threads < 1 || config.threads > WorkerPool::kMaxParts) {
    return {StatusCode::kBadThreads, "threads", config.threads, WorkerPool::kMaxParts};
  }
  if (config.real_time.fifo_priority < 0 || config.real_time.fifo_priority > 99) {
    return {StatusCode::kBadThreads, "real_time.fifo_priority (0..99)", config.real_time.fifo_priority, 99};
  }
  return {};
}

}  // namespace

Status check_config(const Config& config) noexcept {
  for (const Status& status :
       {check_camera(config), check_ladder(config.ladder), EventWindow::check(config.window),
        EventFilter::check(config), EgoMotion::check(config.motion), FocusCostPlane::check(config.focus),
        CarriedDepth::check(config.carry), Scheduler::check(config.rate),
        check_velocity_noise(config.velocity_noise), check_rings(config.rings), check_event_rate(config),
        check_threads(config)}) {
    if (!status.ok()) return status;
  }
  return {};
}

}  // namespace egofocus
