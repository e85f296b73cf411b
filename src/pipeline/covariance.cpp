#include "pipeline/covariance.hpp"

namespace egofocus {

Covariance product(const Covariance& a, const Covariance& b) noexcept {
  Covariance out = Covariance::Zero();
  for (int j = 0; j < kStates; ++j) {  // down the columns, which is how Eigen stores them
    double* const column = out.data() + kStates * j;
    for (int k = 0; k < kStates; ++k) {
      const double* const from = a.data() + kStates * k;
      const double factor = b.data()[kStates * j + k];
      for (int i = 0; i < kStates; ++i) column[i] += from[i] * factor;
    }
  }
  return out;
}

Row product(const Row& h, const Covariance& p) noexcept {
  Row out = Row::Zero();
  for (int k = 0; k < kStates; ++k) {
    const double* const from = p.data() + kStates * k;
    const double factor = h.data()[k];
    for (int i = 0; i < kStates; ++i) out.data()[i] += from[i] * factor;
  }
  return out;
}

double dot(const Row& a, const Row& b) noexcept {
  double sum = 0;
  for (int i = 0; i < kStates; ++i) sum += a.data()[i] * b.data()[i];
  return sum;
}

void subtract_outer(Covariance& p, const Row& a, const Row& b) noexcept {
  for (int j = 0; j < kStates; ++j) {
    for (int i = 0; i < kStates; ++i) p.data()[kStates * j + i] -= a.data()[i] * b.data()[j];
  }
}

void make_symmetric(Covariance& p) noexcept {
  for (int j = 0; j < kStates; ++j) {
    for (int i = 0; i < j; ++i) p(i, j) = p(j, i);
  }
}

}  // namespace egofocus
