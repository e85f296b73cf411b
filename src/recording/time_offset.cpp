#include "recording/time_offset.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "hal/candump_decoder.hpp"
#include "hal/raw_header.hpp"
#include "recording/error.hpp"
#include "recording/event_reader.hpp"
#include "recording/recording_source.hpp"
#include "recording/rotation_from_events.hpp"

namespace egofocus::recording {
namespace {

constexpr std::int64_t kWindowUs = 20000;
constexpr std::int64_t kHopUs = 10000;
constexpr std::size_t kHalfAverage = 25;  // hops on either side of the running mean that is taken off
constexpr double kStepUs = 1000;          // of the offsets that are tried
constexpr std::size_t kParts = 5;
constexpr std::size_t kFewestWindows = 60;

struct Gyro {
  std::int64_t t_us = 0;
  Rate rate{};
};

// The gyro's samples in the camera frame, in order of time.
std::vector<Gyro> read_gyro(const Folder& folder) {
  const auto decoder = make_can_decoder(folder);
  CandumpDecoder log;
  const double* r = folder.camera.config.motion.camera_from_body;
  std::vector<Gyro> result;
  std::span<const std::byte> left = folder.can.bytes();
  CanFrame frame;
  while (!left.empty()) {
    Decoded done = log.feed(left, {&frame, 1});
    if (done.consumed == 0) done = log.finish(left, {&frame, 1});
    left = left.subspan(done.consumed);
    if (done.produced == 0) continue;
    MotionSamples samples;
    decoder->feed(frame, samples);
    for (std::size_t i = 0; i < samples.imu_count; ++i) {
      const ImuSample& s = samples.imu[i];
      if (!s.has_gyro) continue;
      Gyro gyro;
      gyro.t_us = s.t_us;
      for (std::size_t k = 0; k < 3; ++k) {
        gyro.rate[k] =
            r[3 * k] * s.gyro_rad_s[0] + r[3 * k + 1] * s.gyro_rad_s[1] + r[3 * k + 2] * s.gyro_rad_s[2];
      }
      result.push_back(gyro);
    }
  }
  std::stable_sort(result.begin(), result.end(),
                   [](const Gyro& a, const Gyro& b) { return a.t_us < b.t_us; });
  return result;
}

// The angle turned since the first sample: trapezoids between samples. Its differences are exact means.
class Angle {
 public:
  explicit Angle(const std::vector<Gyro>& gyro) : gyro_(gyro), sums_(gyro.size()) {
    for (std::size_t i = 1; i < gyro.size(); ++i) {
      const double s = static_cast<double>(gyro[i].t_us - gyro[i - 1].t_us) * 1e-6;
      for (std::size_t k = 0; k < 3; ++k)
        sums_[i][k] = sums_[i - 1][k] + s * (gyro[i].rate[k] + gyro[i - 1].rate[k]) / 2;
    }
  }
  [[nodiscard]] Rate mean(double from_us, double to_us) const {
    const Rate a = at(from_us);
    const Rate b = at(to_us);
    Rate result{};
    for (std::size_t k = 0; k < 3; ++k) result[k] = (b[k] - a[k]) / ((to_us - from_us) * 1e-6);
    return result;
  }

 private:
  [[nodiscard]] Rate at(double t_us) const {
    const auto after =
        std::upper_bound(gyro_.begin() + 1, gyro_.end() - 1, t_us,
                         [](double t, const Gyro& g) { return t < static_cast<double>(g.t_us); });
    const auto i = static_cast<std::size_t>(after - gyro_.begin());
    const double step = static_cast<double>(gyro_[i].t_us - gyro_[i - 1].t_us);
    const double part = step > 0 ? (t_us - static_cast<double>(gyro_[i - 1].t_us)) / step : 0;
    Rate result{};
    for (std::size_t k = 0; k < 3; ++k) result[k] = sums_[i - 1][k] + part * (sums_[i][k] - sums_[i - 1][k]);
    return result;
  }
  const std::vector<Gyro>& gyro_;
  std::vector<Rate> sums_;
};

// What changes within half a second.
std::vector<Rate> without_slow_part(const std::vector<Rate>& rates) {
  std::vector<Rate> result(rates.size());
  for (std::size_t i = 0; i < rates.size(); ++i) {
    const std::size_t first = i > kHalfAverage ? i - kHalfAverage : 0;
    const std::size_t end = std::min(rates.size(), i + kHalfAverage + 1);
    for (std::size_t k = 0; k < 3; ++k) {
      double sum = 0;
      for (std::size_t j = first; j < end; ++j) sum += rates[j][k];
      result[i][k] = rates[i][k] - sum / static_cast<double>(end - first);
    }
  }
  return result;
}

struct Windows {
  std::vector<std::int64_t> middle_us;
  std::vector<Rate> seen;  // by the events
};

// Correlation of the windows [first, end) for each offset from -range to range.
std::vector<double> correlations(const Windows& windows, const Angle& angle, double range_us,
                                 std::size_t first, std::size_t end) {
  const std::vector<Rate> seen = without_slow_part(windows.seen);
  std::vector<double> result;
  std::vector<Rate> turned(seen.size());
  for (double late_us = -range_us; late_us <= range_us; late_us += kStepUs) {
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const double from = static_cast<double>(windows.middle_us[i]) + late_us - kWindowUs / 2.0;
      turned[i] = angle.mean(from, from + kWindowUs);
    }
    const std::vector<Rate> moved = without_slow_part(turned);
    double both = 0, own = 1e-12, other = 1e-12;
    for (std::size_t i = first; i < end; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        both += seen[i][k] * moved[i][k];
        own += seen[i][k] * seen[i][k];
        other += moved[i][k] * moved[i][k];
      }
    }
    result.push_back(both / std::sqrt(own * other));
  }
  return result;
}

// The peak, between the steps by the parabola through its neighbours. Nothing at either end.
std::optional<double> peak_us(const std::vector<double>& values, double range_us) {
  const auto at = static_cast<std::size_t>(std::max_element(values.begin(), values.end()) - values.begin());
  if (at == 0 || at + 1 == values.size()) return std::nullopt;
  const double bend = values[at - 1] - 2 * values[at] + values[at + 1];
  const double part = bend < 0 ? (values[at - 1] - values[at + 1]) / (2 * bend) : 0;
  return (static_cast<double>(at) + part) * kStepUs - range_us;
}

Windows see(const Folder& folder, std::int64_t first_us, std::int64_t last_us) {
  const std::string where = (folder.path / "events.raw").string();
  RawHeader header;
  require(parse_raw_header(folder.events.bytes(), header), where, ExitCode::kBadFile);
  EventReader reader(folder.events.bytes(), header);
  RotationFromEvents rotation(folder.camera.config.camera);
  Windows result;
  for (std::int64_t t = first_us; t <= last_us; t += kHopUs) {
    Rate rate{};
    if (!rotation.estimate(reader.between(t - kWindowUs / 2, t + kWindowUs / 2), t, rate)) continue;
    result.middle_us.push_back(t);
    result.seen.push_back(rate);
  }
  return result;
}

}  // namespace

TimeOffset estimate_time_offset(const Folder& folder, double range_ms) {
  const std::string where = folder.path.string();
  if (folder.can.bytes().empty())
    throw Error(ExitCode::kMotion, where, "has no can.log, so no IMU whose time could be compared.");
  const std::vector<Gyro> gyro = read_gyro(folder);
  if (gyro.size() < 3)
    throw Error(ExitCode::kMotion, where,
                "has no gyro in its CAN log. [[can.signals]] needs roles gyro_x, gyro_y or gyro_z.");

  const double range_us = range_ms * 1000;
  const auto margin_us = static_cast<std::int64_t>(range_us) + kWindowUs;
  const Windows windows = see(folder, gyro.front().t_us + margin_us, gyro.back().t_us - margin_us);
  const std::size_t count = windows.seen.size();
  if (count < kFewestWindows) {
    throw Error(ExitCode::kMotion, where,
                "has less than a second of gyro and events together. Record 10 s in which the camera is "
                "turned to and fro.");
  }
  const Angle angle(gyro);
  const std::vector<double> whole = correlations(windows, angle, range_us, 0, count);

  TimeOffset result;
  result.windows = count;
  result.correlation = *std::max_element(whole.begin(), whole.end());
  const std::optional<double> late_us = peak_us(whole, range_us);
  result.late_ms = late_us.value_or(0) / 1000;
  result.old_imu_delay_us = folder.camera.can.motion.imu_delay_us;
  result.imu_delay_us = result.old_imu_delay_us + std::llround(result.late_ms * 1000);

  double squares = 0;
  std::size_t parts = 0;
  for (std::size_t i = 0; i < kParts; ++i) {
    const auto part = peak_us(
        correlations(windows, angle, range_us, count * i / kParts, count * (i + 1) / kParts), range_us);
    if (!part) continue;
    ++parts;
    squares += (*part / 1000 - result.late_ms) * (*part / 1000 - result.late_ms);
  }
  result.sigma_ms = parts > 1 ? std::sqrt(squares / static_cast<double>(parts * (parts - 1))) : range_ms;

  std::vector<Rate> turned;
  for (const std::int64_t t : windows.middle_us)
    turned.push_back(
        angle.mean(static_cast<double>(t) - kWindowUs / 2.0, static_cast<double>(t) + kWindowUs / 2.0));
  double energy = 0;
  for (const Rate& rate : without_slow_part(turned))
    for (const double w : rate) energy += w * w;
  result.rotation_rad_s = std::sqrt(energy / static_cast<double>(count));

  if (!late_us) {
    result.doubt = "the best offset lies at the end of the range: widen it with --range-ms";
  } else if (result.correlation < 0.5) {
    result.doubt =
        "events and gyro hardly agree: turn the camera to and fro while recording, and check "
        "camera_from_body";
  } else if (result.sigma_ms > 3) {
    result.doubt = "the parts of the recording disagree: record longer, with more rotation";
  }
  return result;
}

}  // namespace egofocus::recording
