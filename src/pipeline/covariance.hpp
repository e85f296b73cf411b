// The velocity filter's covariance and the few products it needs, as plain loops: one order of summation on
// every target, and quick in debug builds as well. Thread: any. RT: yes.
#pragma once

#include "pipeline/eigen.hpp"

namespace egofocus {

inline constexpr int kStates = 13;
using Covariance = egofocus_eigen::Matrix<double, kStates, kStates>;
/// One row of a measurement matrix.
using Row = egofocus_eigen::Matrix<double, 1, kStates>;

Covariance product(const Covariance& a, const Covariance& b) noexcept;
/// h * p for a symmetric p.
Row product(const Row& h, const Covariance& p) noexcept;
double dot(const Row& a, const Row& b) noexcept;
/// p -= a^T b.
void subtract_outer(Covariance& p, const Row& a, const Row& b) noexcept;
/// Copies the lower triangle over the upper: rounding must not make p drift from symmetry.
void make_symmetric(Covariance& p) noexcept;

}  // namespace egofocus
