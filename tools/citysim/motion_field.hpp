// How fast what is static moves through the picture.
#pragma once

#include <array>

namespace egofocus::citysim {

/// On the plane z = 1, in 1/s, of a point at (x, y) with inverse depth rho (1/m), for a camera with velocity
/// v (m/s) and rate w (rad/s) in its own frame: Longuet-Higgins and Prazdny, 1980.
template <typename Real, typename Vector>
std::array<Real, 2> motion_field(Real x, Real y, Real rho, const Vector& v, const Vector& w) {
  return {rho * (x * v[2] - v[0]) + x * y * w[0] - (1 + x * x) * w[1] + y * w[2],
          rho * (y * v[2] - v[1]) + (1 + y * y) * w[0] - x * y * w[1] - x * w[2]};
}

}  // namespace egofocus::citysim
