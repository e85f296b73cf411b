// Three-vectors and rotation matrices in plain doubles: the order of operations is written down, so that the
// simulator gives the same bits on every machine.
#pragma once

#include <array>

#include "core/elementary.hpp"

namespace egofocus::sim {

using Vec3 = std::array<double, 3>;
using Mat3 = std::array<Vec3, 3>;  ///< rows

inline constexpr Mat3 kIdentity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

inline Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 operator*(double s, const Vec3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline double dot(const Vec3& a, const Vec3& b) {
  return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2];
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Vec3 operator*(const Mat3& m, const Vec3& v) {
  return {dot(m[0], v), dot(m[1], v), dot(m[2], v)};
}
inline Mat3 transpose(const Mat3& m) {
  return {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}}};
}
inline Mat3 operator*(const Mat3& a, const Mat3& b) {
  const Mat3 columns = transpose(b);
  Mat3 product;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) product[i][j] = dot(a[i], columns[j]);
  }
  return product;
}

/// Rotation by |v| radians about v (Rodrigues).
inline Mat3 rotation(const Vec3& v) {
  const double angle = square_root(dot(v, v));
  if (angle < 1e-12) return kIdentity;
  const Vec3 k = (1.0 / angle) * v;
  const double s = sine(angle);
  const double c = 1.0 - cosine(angle);
  return {{{1.0 - c * (k[1] * k[1] + k[2] * k[2]), c * k[0] * k[1] - s * k[2], c * k[0] * k[2] + s * k[1]},
           {c * k[0] * k[1] + s * k[2], 1.0 - c * (k[0] * k[0] + k[2] * k[2]), c * k[1] * k[2] - s * k[0]},
           {c * k[0] * k[2] - s * k[1], c * k[1] * k[2] + s * k[0], 1.0 - c * (k[0] * k[0] + k[1] * k[1])}}};
}

}  // namespace egofocus::sim
