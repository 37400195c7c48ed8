// The loops over dense columns in which a factorisation and its solves spend their time. No two arguments overlap.
#pragma once

#include <cstddef>
#include <cstdint>

namespace gaitflow::dense {

// Numbers that the processor handles at once, by an extension that GCC and Clang have. Compilers make code of plain loops
// that takes a seventh longer.
#if defined(__AVX512F__)
constexpr std::size_t lanes = 8;
#elif defined(__AVX__)
constexpr std::size_t lanes = 4;
#else
constexpr std::size_t lanes = 2;
#endif
typedef double Lanes __attribute__((vector_size(lanes * sizeof(double)), aligned(sizeof(double)), may_alias));

// Columns are kept in whole blocks of so many rows, so that loops over rows have no rest; `panel` columns are handled at
// once, so that what is read is used more than once.
constexpr std::size_t block = lanes < 4 ? 4 : 8, panel = 4;

inline std::size_t padded(std::size_t rows) { return (rows + block - 1) / block * block; }

// The product of two vectors, by four sums that do not wait for each other.
inline double product(const double* __restrict one, const double* __restrict other, std::size_t count) {
  double sums[4] = {0, 0, 0, 0};
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4)
    for (std::size_t lane = 0; lane < 4; ++lane) sums[lane] += one[i + lane] * other[i + lane];
  for (; i < count; ++i) sums[0] += one[i] * other[i];
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

// target[to[i]] += from[i] for i from `first` on.
inline void scatter(double* __restrict target, const double* __restrict from, const std::uint32_t* __restrict to,
                    std::size_t first, std::size_t count) {
  for (std::size_t i = first; i < count; ++i) target[to[i]] += from[i];
}

// One block of rows of `columns` columns: the target's, or zeros, minus `left` times the weights. left has `count` columns
// and weights has `panel` numbers for each of them; columns of target and left are a stride apart.
template <std::size_t columns, bool from_zeros>
inline void subtract_product(double* __restrict target, std::size_t stride, const double* __restrict left,
                             std::size_t left_stride, const double* __restrict weights, std::size_t count) {
  constexpr std::size_t parts = block / lanes;
  Lanes sums[columns][parts] = {};
  for (std::size_t k = 0; k < count; ++k, left += left_stride, weights += panel)
    for (std::size_t part = 0; part < parts; ++part) {
      const Lanes rows = *reinterpret_cast<const Lanes*>(left + part * lanes);
      for (std::size_t c = 0; c < columns; ++c) sums[c][part] += rows * weights[c];
    }
  for (std::size_t c = 0; c < columns; ++c)
    for (std::size_t part = 0; part < parts; ++part) {
      Lanes& own = *reinterpret_cast<Lanes*>(target + c * stride + part * lanes);
      own = from_zeros ? -sums[c][part] : own - sums[c][part];
    }
}

}  // namespace gaitflow::dense
