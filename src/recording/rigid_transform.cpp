#include "recording/rigid_transform.hpp"

#include <algorithm>
#include <cmath>

namespace egofocus::recording {
namespace {

/// Files have rounded numbers: x keeps its direction, y its plane, z is their product.
void make_orthonormal(std::array<double, 9>& r) {
  const auto normalise = [](double* row) {
    const double norm = std::sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
    for (int i = 0; i < 3; ++i) row[i] /= norm;
  };
  double* const x = &r[0];
  double* const y = &r[3];
  normalise(x);
  const double along = x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
  for (int i = 0; i < 3; ++i) y[i] -= along * x[i];
  normalise(y);
  r[6] = x[1] * y[2] - x[2] * y[1];
  r[7] = x[2] * y[0] - x[0] * y[2];
  r[8] = x[0] * y[1] - x[1] * y[0];
}

}  // namespace

RigidTransform operator*(const RigidTransform& a, const RigidTransform& b) {
  RigidTransform result;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* r = &a.rotation[3 * row];
    for (std::size_t column = 0; column < 3; ++column) {
      result.rotation[3 * row + column] =
          r[0] * b.rotation[column] + r[1] * b.rotation[3 + column] + r[2] * b.rotation[6 + column];
    }
    result.translation_m[row] = r[0] * b.translation_m[0] + r[1] * b.translation_m[1] +
                                r[2] * b.translation_m[2] + a.translation_m[row];
  }
  return result;
}

RigidTransform inverse(const RigidTransform& transform) {
  RigidTransform result;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      result.rotation[3 * row + column] = transform.rotation[3 * column + row];
    }
  }
  for (std::size_t row = 0; row < 3; ++row) {
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) sum += result.rotation[3 * row + k] * transform.translation_m[k];
    result.translation_m[row] = -sum;
  }
  return result;
}

bool is_rotation(const std::array<double, 9>& r) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      double sum = i == k ? -1.0 : 0.0;
      for (std::size_t j = 0; j < 3; ++j) sum += r[3 * i + j] * r[3 * k + j];
      if (!(std::abs(sum) <= 0.01)) return false;
    }
  }
  const double determinant = r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
                             r[2] * (r[3] * r[7] - r[4] * r[6]);
  return determinant > 0;
}

bool from_matrix(std::span<const double> values, RigidTransform& transform) {
  static constexpr double kLastRow[4] = {0, 0, 0, 1};
  if (values.size() != 16 ||
      !std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); }))
    return false;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      transform.rotation[3 * row + column] = values[4 * row + column];
    transform.translation_m[row] = values[4 * row + 3];
  }
  for (std::size_t column = 0; column < 4; ++column) {
    if (std::abs(values[12 + column] - kLastRow[column]) > 1e-6) return false;
  }
  if (!is_rotation(transform.rotation)) return false;
  make_orthonormal(transform.rotation);
  return true;
}

PoseSample pose_of(std::int64_t t_us, const RigidTransform& world_from_camera) {
  const auto& r = world_from_camera.rotation;
  // The largest of the four gives the others by division: no loss of digits for any rotation.
  const double squares[4] = {1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8], 1 - r[0] - r[4] + r[8],
                             1 + r[0] + r[4] + r[8]};
  const std::ptrdiff_t largest = std::max_element(squares, squares + 4) - squares;
  double q[4] = {0, 0, 0, 0};
  if (largest == 0) {
    q[0] = squares[0], q[1] = r[1] + r[3], q[2] = r[2] + r[6], q[3] = r[7] - r[5];
  } else if (largest == 1) {
    q[0] = r[1] + r[3], q[1] = squares[1], q[2] = r[5] + r[7], q[3] = r[2] - r[6];
  } else if (largest == 2) {
    q[0] = r[2] + r[6], q[1] = r[5] + r[7], q[2] = squares[2], q[3] = r[3] - r[1];
  } else {
    q[0] = r[7] - r[5], q[1] = r[2] - r[6], q[2] = r[3] - r[1], q[3] = squares[3];
  }
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  const double sign = q[3] < 0 ? -1.0 : 1.0;
  PoseSample pose;
  pose.t_us = t_us;
  for (std::size_t i = 0; i < 4; ++i) pose.orientation_xyzw[i] = sign * q[i] / norm;
  for (std::size_t i = 0; i < 3; ++i) pose.position_m[i] = world_from_camera.translation_m[i];
  return pose;
}

}  // namespace egofocus::recording
