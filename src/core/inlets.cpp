#include "core/inlets.hpp"

namespace egofocus {

std::size_t Inlets::push(std::span<const Event> events) noexcept {
  return rings_->events.push(events);
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
