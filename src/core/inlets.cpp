#include "core/inlets.hpp"

namespace egofocus {

std::size_t Inlets::push(std::span<const Event> events) noexcept {
  if (rings_->tap.events != nullptr) rings_->tap.events(rings_->tap.self, events);
  if (!rings_->thinner.is_on()) return rings_->events.push(events);
  constexpr std::size_t kBatch = 64;
  Event kept[kBatch];
  std::size_t count = 0;
  std::size_t lost = 0;
  std::uint64_t thinned = 0;
  for (const Event& event : events) {
    if (!rings_->thinner.keep(event.t_us)) {
      ++thinned;
      continue;
    }
    kept[count++] = event;
    if (count < kBatch) continue;
    lost += count - rings_->events.push(kept);
    count = 0;
  }
  lost += count - rings_->events.push({kept, count});
  // One writer: no atomic addition is needed.
  rings_->over_rate.store(rings_->over_rate.load(std::memory_order_relaxed) + thinned,
                          std::memory_order_relaxed);
  return events.size() - lost;
}
std::size_t Inlets::push(std::span<const ImuSample> samples) noexcept {
  return rings_->imu.push(samples);
}
std::size_t Inlets::push(std::span<const OdometrySample> samples) noexcept {
  return rings_->odometry.push(samples);
}
std::size_t Inlets::push(std::span<const PoseSample> samples) noexcept {
  return rings_->poses.push(samples);
}
std::size_t Inlets::event_room() const noexcept {
  return rings_->events.room();
}
std::size_t Inlets::imu_room() const noexcept {
  return rings_->imu.room();
}
std::size_t Inlets::odometry_room() const noexcept {
  return rings_->odometry.room();
}
std::size_t Inlets::pose_room() const noexcept {
  return rings_->poses.room();
}

}  // namespace egofocus
