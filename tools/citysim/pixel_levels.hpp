// Loops over a row of pixels, written so that they become vector code: light -> log light -> filtered level,
// and which pixels need a closer look. Pointers of one call must not overlap; each has `n` elements.
#pragma once

#include <cstdint>

namespace egofocus::citysim {

/// Log light in units of 2^-24. All values stay within +-14: 2^28 units.
using Level = std::int32_t;
inline constexpr float kLevelOne = 0x1p24f;

/// Light counts as at least and at most this; not a number counts as the least.
inline constexpr float kLeastLight = 1e-6f;
inline constexpr float kMostLight = 1e6f;

/// log[i] = natural log of light[i] + dark.
void log_levels(const float* light, float dark, int n, Level* log);

/// How a pixel's low pass moves in one step: k = dt / tau = k_dark + k_light * light, at most 80.
struct LowPassRate {
  float k_dark = 0;
  float k_light = 0;

  [[nodiscard]] float of(float light) const {
    light = light > 0.0f ? light : 0.0f;
    const float k = k_dark + k_light * light;
    return k < 80.0f ? k : 80.0f;
  }
};

/// level1[i] from level0[i], log light running straight from log0[i] to log1[i], the corner that of `light`.
void low_pass_levels(const float* light, const LowPassRate& rate, const Level* log0, const Level* log1,
                     const Level* level0, int n, Level* level1);

/// marked[i] = 1 where level[i] has reached upper[i] or lower[i].
void mark_crossed(const Level* level, const Level* upper, const Level* lower, int n, std::uint8_t* marked);

/// As above for filtered levels, and where the level may have been beyond a bound between the two times: it
/// turns where it meets the log light, so never beyond log0.
void mark_crossed(const Level* log0, const Level* log1, const Level* level0, const Level* level1,
                  const Level* upper, const Level* lower, int n, std::uint8_t* marked);

}  // namespace egofocus::citysim
