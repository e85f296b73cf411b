#include "support/event_sensor.hpp"

#include <algorithm>
#include <tuple>

namespace egofocus::sim {

std::vector<Ray> pixel_rays(const CameraModel& camera) {
  const Intrinsics& k = camera.intrinsics;
  const double* c = camera.coefficients;
  std::vector<Ray> rays;
  for (std::int32_t v = 0; v < k.height_px; ++v) {
    for (std::int32_t u = 0; u < k.width_px; ++u) {
      const double xd = (u - k.cx_px) / k.fx_px;
      const double yd = (v - k.cy_px) / k.fy_px;
      Ray ray{xd, yd};
      for (int i = 0; i < 60 && camera.distortion == Distortion::kPlumbBob; ++i) {
        const double r2 = ray.x * ray.x + ray.y * ray.y;
        const double radial = 1.0 + r2 * (c[0] + r2 * (c[1] + r2 * c[4]));
        const double dx = 2.0 * c[2] * ray.x * ray.y + c[3] * (r2 + 2.0 * ray.x * ray.x);
        const double dy = c[2] * (r2 + 2.0 * ray.y * ray.y) + 2.0 * c[3] * ray.x * ray.y;
        ray = {(xd - dx) / radial, (yd - dy) / radial};
      }
      rays.push_back(ray);
    }
  }
  return rays;
}

EventSensor::EventSensor(const Intrinsics& size, const SensorFaults& faults, std::uint64_t seed)
    : width_px_(static_cast<std::uint32_t>(size.width_px)), faults_(faults), random_(seed) {
  pixels_.resize(static_cast<std::size_t>(size.width_px) * static_cast<std::size_t>(size.height_px));
  for (Pixel& pixel : pixels_) {
    pixel.on_threshold = faults_.threshold * (1.0 + faults_.threshold_spread * random_.normal());
    pixel.off_threshold = faults_.threshold * (1.0 + faults_.threshold_spread * random_.normal());
  }
}

Event EventSensor::event_at(std::size_t index, std::int64_t t_us, bool on) const {
  Event event;
  event.t_us = t_us - t_us % faults_.readout_us;
  event.x = static_cast<std::uint16_t>(index % width_px_);
  event.y = static_cast<std::uint16_t>(index / width_px_);
  event.polarity = on ? 1 : 0;
  return event;
}

void EventSensor::change(std::size_t index, std::int64_t t_us, double level, std::vector<Event>& events) {
  Pixel& pixel = pixels_[index];
  const double rise = level - pixel.last;
  const auto span_us = static_cast<double>(t_us - last_us_);
  const auto crossed_at = [&](double crossing) {
    const auto into = static_cast<std::int64_t>(span_us * ((crossing - pixel.last) / rise));
    return last_us_ + std::clamp<std::int64_t>(into, 0, t_us - last_us_ - 1);
  };
  while (level - pixel.reference >= pixel.on_threshold) {
    pixel.reference += pixel.on_threshold;
    events.push_back(event_at(index, crossed_at(pixel.reference), true));
  }
  while (pixel.reference - level >= pixel.off_threshold) {
    pixel.reference -= pixel.off_threshold;
    events.push_back(event_at(index, crossed_at(pixel.reference), false));
  }
  pixel.last = level;
}

void EventSensor::add_noise(std::int64_t t_us, std::vector<Event>& events) {
  const std::int64_t span_us = t_us - last_us_;
  noise_owed_ += faults_.noise_hz * static_cast<double>(pixels_.size()) * static_cast<double>(span_us) * 1e-6;
  for (; noise_owed_ >= 1.0; noise_owed_ -= 1.0) {
    const std::size_t index = random_.below(static_cast<std::uint32_t>(pixels_.size()));
    const std::int64_t at = last_us_ + random_.below(static_cast<std::uint32_t>(span_us));
    events.push_back(event_at(index, at, random_.below(2) == 1));
  }
}

void EventSensor::show(std::int64_t t_us, std::span<const double> view, std::vector<Event>& events) {
  const std::size_t begin = events.size();
  if (!has_view_) {
    // A sensor that has run for a while: its references lie anywhere between the two thresholds.
    for (std::size_t i = 0; i < pixels_.size(); ++i) {
      pixels_[i].last = view[i];
      pixels_[i].reference = view[i] + (random_.uniform() - 0.5) * faults_.threshold;
    }
    has_view_ = true;
  } else {
    for (std::size_t i = 0; i < pixels_.size(); ++i) change(i, t_us, view[i], events);
    add_noise(t_us, events);
  }
  last_us_ = t_us;
  std::sort(events.begin() + static_cast<std::ptrdiff_t>(begin), events.end(),
            [](const Event& a, const Event& b) {
              return std::tie(a.t_us, a.y, a.x, a.polarity) < std::tie(b.t_us, b.y, b.x, b.polarity);
            });
}

}  // namespace egofocus::sim
