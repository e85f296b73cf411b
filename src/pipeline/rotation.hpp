// Rotations as unit quaternions, with the exact exponential and logarithm. Deterministic: + - * / sqrt and
// core/elementary only.
// Thread: any. RT: yes.
#pragma once

#include "pipeline/eigen.hpp"
#include "pipeline/motion_track.hpp"

namespace egofocus {

/// Unit quaternion; the rotation takes p to q p q*.
struct Quaternion {
  double x = 0;
  double y = 0;
  double z = 0;
  double w = 1;
};

/// a after b: (a * b) p = a (b p).
Quaternion operator*(const Quaternion& a, const Quaternion& b) noexcept;
Quaternion conjugate(const Quaternion& q) noexcept;
/// Precondition: not zero.
Quaternion normalized(const Quaternion& q) noexcept;

/// The rotation by |v| radians about v; |v| <= 1e5.
Quaternion from_rotation_vector(const Vec3& v) noexcept;
/// The shortest rotation vector of q, whichever sign q has; at most pi long.
Vec3 to_rotation_vector(const Quaternion& q) noexcept;
Mat3 to_matrix(const Quaternion& q) noexcept;

/// skew(a) b = a x b.
Mat3 skew(const Vec3& a) noexcept;
Vec3 cross(const Vec3& a, const Vec3& b) noexcept;

/// Into the plain, row-major form of the track.
void store(const Mat3& rotation, const Vec3& centre, MotionKnot& knot) noexcept;

}  // namespace egofocus
