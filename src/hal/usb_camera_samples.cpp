#include "hal/usb_camera_samples.hpp"

namespace egofocus {

void UsbCameraSamples::restart(const UsbCameraDriver& driver, const UsbCameraInfo& info,
                               const UsbCameraSettings& settings) noexcept {
  is_inivation_ = driver.is_inivation;
  wants_imu_ = settings.imu;
  imu_axes_ = settings.imu_axes;
  inivation_ = InivationDecoder(info.layout, inivation_.counters());
  evt_ = Evt3Decoder(info.size, evt_.counters());
  clock_.restart(settings.device_time);
}

void UsbCameraSamples::take(std::span<const std::byte> bytes, std::int64_t host_us, bool is_live,
                            Inlets& inlets, UsbCameraCounters& counters) noexcept {
  for (bool more = true; more;) {
    const std::uint64_t jumps = time_jumps();
    const Batch batch = decode(bytes);
    bytes = bytes.subspan(batch.consumed);
    more = !batch.is_last;
    if (time_jumps() != jumps) {
      ++counters.clock_restarts;
      clock_.restart();
    }
    if (is_live && clock_.is_mapped()) {
      push(batch, inlets, counters);
    } else {
      counters.events_unmapped += batch.events;
      if (wants_imu_) counters.imu_unmapped += batch.imu;
    }
  }
  is_inivation_ ? inivation_.end_transfer() : evt_.drop_partial();  // no word crosses transfers
  if (!(is_inivation_ ? inivation_.is_time_known() : evt_.is_time_known())) return;
  // The newest time in a transfer is the one that the host has had no longer than its way here took.
  const std::int64_t device_us = is_inivation_ ? inivation_.time_us() : evt_.time_us();
  clock_.observe(device_us, host_us);
}

UsbCameraSamples::Batch UsbCameraSamples::decode(std::span<const std::byte> bytes) noexcept {
  if (is_inivation_) {
    const InivationDecoded done = inivation_.feed(bytes, events_, imu_);
    return {.consumed = done.consumed,
            .events = done.events,
            .imu = done.imu,
            .is_last = done.events < events_.size() && done.imu < imu_.size()};
  }
  const Decoded done = evt_.feed(bytes, events_);
  return {.consumed = done.consumed,
          .events = done.produced,
          .imu = 0,
          .is_last = done.produced < events_.size()};
}

std::uint64_t UsbCameraSamples::time_jumps() const noexcept {
  return is_inivation_ ? inivation_.counters().time_resets : evt_.counters()[EvtViolation::kTimeReset];
}

void UsbCameraSamples::push(const Batch& batch, Inlets& inlets, UsbCameraCounters& counters) noexcept {
  const std::span<Event> events = std::span(events_).first(batch.events);
  for (Event& event : events) event.t_us = clock_.to_host_us(event.t_us);
  inlets.push(std::span<const Event>(events));
  counters.events_pushed += events.size();
  if (!wants_imu_) return;
  const std::span<ImuSample> samples = std::span(imu_).first(batch.imu);
  for (ImuSample& sample : samples) {
    const ImuSample sensor = sample;
    sample.t_us = clock_.to_host_us(sensor.t_us);
    map_axes(imu_axes_, sensor.gyro_rad_s, sample.gyro_rad_s);
    map_axes(imu_axes_, sensor.accel_m_s2, sample.accel_m_s2);
  }
  inlets.push(std::span<const ImuSample>(samples));
  counters.imu_pushed += samples.size();
}

}  // namespace egofocus
