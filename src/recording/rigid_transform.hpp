// Rotation and translation of calibrations and poses: p_a = R p_b + t, written a_from_b.
#pragma once

#include <array>
#include <span>

#include "egofocus/types.hpp"

namespace egofocus::recording {

struct RigidTransform {
  std::array<double, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< row by row
  std::array<double, 3> translation_m{0, 0, 0};
};

/// a_from_b * b_from_c = a_from_c
[[nodiscard]] RigidTransform operator*(const RigidTransform& a, const RigidTransform& b);
[[nodiscard]] RigidTransform inverse(const RigidTransform& transform);

/// Is it a right-handed rotation, with an error of at most 0.01 in any element of R R^T, and finite?
[[nodiscard]] bool is_rotation(const std::array<double, 9>& rotation);

/// From 16 values, a 4x4 matrix row by row. False if it is no rigid transform; a rotation that was rounded is
/// made orthonormal.
[[nodiscard]] bool from_matrix(std::span<const double> values, RigidTransform& transform);

/// world_from_camera as a pose; the quaternion has a length of 1 and qw >= 0.
[[nodiscard]] PoseSample pose_of(std::int64_t t_us, const RigidTransform& world_from_camera);

}  // namespace egofocus::recording
