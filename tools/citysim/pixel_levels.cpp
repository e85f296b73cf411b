#include "citysim/pixel_levels.hpp"

#include "citysim/clones.hpp"
#include "citysim/logarithm.hpp"
#include "citysim/low_pass.hpp"

namespace egofocus::citysim {

CITYSIM_CLONES void log_levels(const float* __restrict light, float dark, int n, Level* __restrict log) {
  for (int i = 0; i < n; ++i) {
    float v = light[i] + dark;
    v = v > kLeastLight ? v : kLeastLight;
    v = v < kMostLight ? v : kMostLight;
    log[i] = static_cast<Level>(sim::natural_log(v) * kLevelOne);
  }
}

CITYSIM_CLONES void low_pass_levels(const float* __restrict light, const LowPassRate& rate,
                                    const Level* __restrict log0, const Level* __restrict log1,
                                    const Level* __restrict level0, int n, Level* __restrict level1) {
  const LowPassRate r = rate;
  for (int i = 0; i < n; ++i) {
    const LowPassStep<float> step = low_pass_step(r.of(light[i]));
    const float behind = static_cast<float>(level0[i] - log0[i]);
    const float rise = static_cast<float>(log1[i] - log0[i]);
    level1[i] = log1[i] + static_cast<Level>(behind * step.decay - rise * step.lag);
  }
}

CITYSIM_CLONES void mark_crossed(const Level* __restrict level, const Level* __restrict upper,
                                 const Level* __restrict lower, int n, std::uint8_t* __restrict marked) {
  for (int i = 0; i < n; ++i) marked[i] = (level[i] >= upper[i]) | (level[i] <= lower[i]);
}

CITYSIM_CLONES void mark_crossed(const Level* __restrict log0, const Level* __restrict log1,
                                 const Level* __restrict level0, const Level* __restrict level1,
                                 const Level* __restrict upper, const Level* __restrict lower, int n,
                                 std::uint8_t* __restrict marked) {
  for (int i = 0; i < n; ++i) {
    const int at_end = (level1[i] >= upper[i]) | (level1[i] <= lower[i]);
    const int turns = ((log0[i] - level0[i]) ^ (log1[i] - level1[i])) < 0;
    const int between = (log0[i] >= upper[i]) | (log0[i] <= lower[i]);
    marked[i] = static_cast<std::uint8_t>(at_end | (turns & between));
  }
}

}  // namespace egofocus::citysim
