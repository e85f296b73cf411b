// The only file that includes Eigen. Fixed sizes, no vectorisation, no heap; and under a namespace of our
// own: Eigen is templates, so every program that uses it carries weak copies, and the linker keeps one of
// them for all. A user's vectorised copy in place of ours would change the bits (a test runs `nm`).
//
// Use it for 3x3 and blocks. The product of two matrices of 8 or more rows would choose a blocked kernel
// whose order of summation depends on the target: write such loops out.
#pragma once

#ifdef EIGEN_CORE_H
#error "include pipeline/eigen.hpp instead of Eigen"
#endif

#define EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_PARALLELIZE
#define EIGEN_NO_DEBUG
#define EIGEN_NO_MALLOC
#define EIGEN_MPL2_ONLY
#define EIGEN_MAX_STATIC_ALIGN_BYTES 0
#define Eigen egofocus_eigen
#include <Eigen/Core>
#undef Eigen

namespace egofocus {

using Vec3 = egofocus_eigen::Matrix<double, 3, 1>;
using Mat3 = egofocus_eigen::Matrix<double, 3, 3>;

}  // namespace egofocus
