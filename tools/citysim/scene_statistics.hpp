// What a family's scenes are like: how far things are, how much is blank, moving, or outside the ladder.
#pragma once

#include <array>
#include <cstdint>

#include "citysim/workers.hpp"
#include "citysim/world.hpp"

namespace egofocus::citysim {

/// Upper bounds of the depth histogram, m; beyond the last and the sky are bins, too.
inline constexpr std::array<double, 9> kDepthBounds_m = {0.5, 1, 2, 4, 8, 16, 32, 80, 256};

/// Shares are of pixels of the working grid unless said otherwise.
struct SceneStatistics {
  std::uint64_t views = 0;
  std::array<double, kDepthBounds_m.size() + 2> depth_share{};
  double textureless_share = 0;   ///< log light varies by less than kBlank over the 5x5 pixels around
  double mover_share = 0;         ///< on something that moves
  double nearer_share = 0;        ///< of views with parallax: nearer than the ladder's last step
  double worst_nearer_share = 0;  ///< of the world where it is largest
  double farther_share = 0;       ///< of views with parallax: beyond the first half step, the sky left out
  double no_parallax_views = 0;   ///< share of the views
  double full_ladder_views = 0;   ///< share of the views whose ladder spans all it may, but for a tenth
  double motion_px_s = 0;         ///< median over the views with parallax of the median image speed
  double mean_speed_m_s = 0;
  double top_speed_m_s = 0;
  double top_rate_rad_s = 0;
};

inline constexpr double kBlank = 0.08;

/// Looks at `worlds` worlds of the family, seeds from `seed` on, `views` times in each.
[[nodiscard]] SceneStatistics scene_statistics(Family family, int worlds, int views, std::uint64_t seed,
                                               Workers& workers);

}  // namespace egofocus::citysim
