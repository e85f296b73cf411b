// Between the structs of the C header and those of the C++ API, field by field. Structured bindings name
// every member, so a field that one side gains alone does not compile. Thread: any. RT: yes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "egofocus/config.hpp"
#include "egofocus/egofocus.h"
#include "egofocus/health.hpp"
#include "egofocus/status.hpp"
#include "egofocus/types.hpp"

namespace egofocus {

/// Enumerators of `c` must be known ones: see c_config_problem(). `hot_pixels` keeps pointing to the caller's
/// array.
Config config_from_c(const egofocus_config& c) noexcept;
/// The first field of `c` whose enumerator is unknown; ok when there is none.
Status c_config_problem(const egofocus_config& c) noexcept;
egofocus_config config_to_c(const Config& config) noexcept;

egofocus_status status_to_c(const Status& status) noexcept;
Status status_from_c(const egofocus_status& c) noexcept;

Event sample_from_c(const egofocus_event& c) noexcept;
ImuSample sample_from_c(const egofocus_imu_sample& c) noexcept;
OdometrySample sample_from_c(const egofocus_odometry_sample& c) noexcept;
PoseSample sample_from_c(const egofocus_pose_sample& c) noexcept;

egofocus_depth_frame frame_to_c(const DepthFrame& frame) noexcept;
/// The pixels, their scale and the grid size alone: what metric_depth() needs.
DepthFrame pixels_from_c(const egofocus_depth_frame& c) noexcept;
egofocus_health health_to_c(const Health& health) noexcept;

}  // namespace egofocus
