#include "pipeline/velocity_noise.hpp"

#include "core/elementary.hpp"

namespace egofocus {
namespace {

/// One step of a well-mixing 64-bit hash (multiply and xor-shift, constants of SplitMix64).
std::uint64_t mix_bits(std::uint64_t x) noexcept {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

/// Mean 0, deviation 1: the sum of twelve uniform numbers needs no logarithm, whose bits libm does not
/// promise.
double normal(std::uint64_t key) noexcept {
  double sum = -6.0;
  for (std::uint64_t i = 0; i < 12; ++i) sum += static_cast<double>(mix_bits(key + i) >> 11) * 0x1p-53;
  return sum;
}

double length(const double (&v)[3]) noexcept {
  return square_root(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double sigma(const VelocityNoise& noise, double norm) noexcept {
  const double share = noise.percent / 100.0;
  return noise.kind == NoiseKind::kVariance ? square_root(share * norm) : share * norm;
}

}  // namespace

Status check_velocity_noise(const VelocityNoise& noise) noexcept {
  if (!(noise.percent >= 0 && noise.percent <= 1000)) {
    return {StatusCode::kBadMotion, "velocity_noise.percent (0..1000)", status_value(noise.percent), 1000};
  }
  return {};
}

void add_velocity_noise(const VelocityNoise& noise, std::int64_t tick_us,
                        std::span<MotionSample> samples) noexcept {
  double speed = 0;
  double rate = 0;
  for (const MotionSample& sample : samples) {
    speed += length(sample.velocity_m_s);
    rate += length(sample.angular_rate_rad_s);
  }
  const auto count = static_cast<double>(samples.size());
  const double sigma_m_s = sigma(noise, speed / count);
  const double sigma_rad_s = sigma(noise, rate / count);
  const std::uint64_t tick_key = mix_bits(mix_bits(noise.seed) ^ static_cast<std::uint64_t>(tick_us));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::uint64_t sample_key = mix_bits(tick_key ^ (noise.draw == NoiseDraw::kSample ? i : 0));
    for (std::uint64_t axis = 0; axis < 3; ++axis) {
      samples[i].velocity_m_s[axis] += sigma_m_s * normal(mix_bits(sample_key ^ axis));
      samples[i].angular_rate_rad_s[axis] += sigma_rad_s * normal(mix_bits(sample_key ^ (axis + 3)));
    }
  }
}

bool noisy_track(const VelocityNoise& noise, const EgoMotion& ego_motion, std::int64_t oldest_us,
                 std::int64_t begin_us, std::int64_t tick_us, MotionTrack& out) noexcept {
  MotionSample samples[EgoMotion::kMaxSamples];
  const int count = ego_motion.samples(oldest_us, tick_us, samples);
  if (count == 0) return false;
  const std::span<MotionSample> used(samples, static_cast<std::size_t>(count));
  add_velocity_noise(noise, tick_us, used);
  integrate_track(used, begin_us, tick_us, out);
  return true;
}

}  // namespace egofocus
