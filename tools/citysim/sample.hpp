// One training sample: the events of a window, how the camera moved in it, and the truth at its end.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "citysim/film.hpp"
#include "citysim/true_ladder.hpp"

namespace egofocus::citysim {

/// Velocities of the camera in its own frame, at a time within the window.
struct SampleMotion {
  std::int32_t t_us = 0;  ///< before the window's end: <= 0
  std::array<float, 3> velocity_m_s{};
  std::array<float, 3> rate_rad_s{};
};

/// Time 0 is the window's end, about which the truth is. Truth lies on the working grid (the camera's pinhole
/// part), row-major.
struct Sample {
  static constexpr int kMotions = kLongestWindowUs / 10000 + 1;

  Family family{};
  bool night = false;
  std::uint64_t seed = 0;      ///< of its world
  std::int64_t at_us = 0;      ///< of the window's end in that world
  std::int32_t window_us = 0;  ///< events lie in [-window_us, 0]
  double z_near_m = 0;
  CameraModel camera;
  std::array<SampleMotion, kMotions> motion;
  std::vector<Event> events;         ///< on the distorted sensor; t_us <= 0
  std::vector<float> inverse_depth;  ///< 1/m; 0: the sky
  std::vector<std::uint8_t> moving;  ///< 1: on something that moves by itself
};

/// Windows of one world, up to a second long and no longer than the library's own ladder allows, three to a
/// take: the first at a random time, the others each later by 0.3 to 0.5 of a window. (Ticks at 20 Hz overlap
/// by more.) Nine of ten takes have parallax where the world has any, most of them all that the ladder can
/// use.
[[nodiscard]] std::vector<Sample> draw_samples(const World& world, std::uint64_t seed, double duration_s,
                                               int count, Workers& workers);

/// The bytes of a sample in a shard (README: "Samples"), little-endian.
[[nodiscard]] std::vector<std::byte> sample_bytes(const Sample& sample);

}  // namespace egofocus::citysim
