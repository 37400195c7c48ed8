// The loops over dense columns in which a factorisation and its solves spend their time. No two arguments overlap.
#pragma once

#include <cstddef>

namespace gaitflow::dense {

// The product of two vectors, by four sums that do not wait for each other.
inline double product(const double* __restrict one, const double* __restrict other, std::size_t count) {
  double sums[4] = {0, 0, 0, 0};
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) sums[lane] += one[i + lane] * other[i + lane];
  for (; i < count; ++i) sums[0] += one[i] * other[i];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

// target += from.
inline void add(double* __restrict target, const double* __restrict from, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) target[i] += from[i];
}

// Two columns -= the products of as many columns of L with a factor for each.
template <std::size_t columns>
inline void subtract(double* __restrict one, double* __restrict other, const double* __restrict from,
                     std::size_t rows, const double* __restrict factors, const double* __restrict others,
                     std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    double sum = one[i], second = other[i];
    for (std::size_t k = 0; k < columns; ++k) {
      sum -= from[k * rows + i] * factors[k];
      second -= from[k * rows + i] * others[k];
    }
    one[i] = sum, other[i] = second;
  }
}

}  // namespace gaitflow::dense
