// How near things come on a world's way: what somebody would configure as the ladder's near limit there.
#pragma once

#include "citysim/optics.hpp"
#include "citysim/scene.hpp"
#include "citysim/trajectory.hpp"

namespace egofocus::citysim {

/// The depth that `share` (0..1) of all pixels fall short of, over looks spread evenly along the trajectory
/// from a camera of these intrinsics; in whole centimetres, within kNearest_m and kFarthest_m.
[[nodiscard]] double near_limit_m(const Scene& scene, const Trajectory& trajectory, const Mount& mount,
                                  const Intrinsics& grid, double share);

inline constexpr double kNearest_m = 0.1;
inline constexpr double kFarthest_m = 5;

}  // namespace egofocus::citysim
