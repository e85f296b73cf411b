#include "pipeline/rotation.hpp"

#include "core/elementary.hpp"

namespace egofocus {

Quaternion operator*(const Quaternion& a, const Quaternion& b) noexcept {
  return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
          a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}

Quaternion conjugate(const Quaternion& q) noexcept {
  return {-q.x, -q.y, -q.z, q.w};
}

Quaternion normalized(const Quaternion& q) noexcept {
  const double scale = 1 / square_root(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {q.x * scale, q.y * scale, q.z * scale, q.w * scale};
}

Quaternion from_rotation_vector(const Vec3& v) noexcept {
  const double angle2 = v.squaredNorm();
  double s = 0;  // sin(angle / 2) / angle
  double c = 0;
  if (angle2 < 1e-4) {  // Taylor: the terms left out are below 1e-17
    s = 0.5 - angle2 / 48 + angle2 * angle2 / 3840;
    c = 1 - angle2 / 8 + angle2 * angle2 / 384;
  } else {
    const double angle = square_root(angle2);
    s = sine(angle / 2) / angle;
    c = cosine(angle / 2);
  }
  return normalized({s * v[0], s * v[1], s * v[2], c});
}

Vec3 to_rotation_vector(const Quaternion& q) noexcept {
  const double sign = q.w < 0 ? -1 : 1;
  const Vec3 axis(sign * q.x, sign * q.y, sign * q.z);
  const double w = sign * q.w;
  const double n = square_root(axis.squaredNorm());
  if (n < 1e-3) {  // atan(n / w) / n by its series: no division by a vanishing n
    const double y2 = (n / w) * (n / w);
    return axis * (2 / w * (1 - y2 / 3 + y2 * y2 / 5));
  }
  return axis * (2 * arc_tangent2(n, w) / n);
}

Mat3 to_matrix(const Quaternion& q) noexcept {
  Mat3 m;
  m << 1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y - q.z * q.w), 2 * (q.x * q.z + q.y * q.w),
      2 * (q.x * q.y + q.z * q.w), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z - q.x * q.w),
      2 * (q.x * q.z - q.y * q.w), 2 * (q.y * q.z + q.x * q.w), 1 - 2 * (q.x * q.x + q.y * q.y);
  return m;
}

Mat3 skew(const Vec3& a) noexcept {
  Mat3 m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

Vec3 cross(const Vec3& a, const Vec3& b) noexcept {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace egofocus
