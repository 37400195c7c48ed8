// Solves a KKT system with the rows of short_rows.hpp left out of the matrix. In: how many unknowns, equality and
// inequality rows there are, then H, J_E and J_I row by row, the diagonal entries of the rows, and the right side. Out:
// the solution, and how many rows were short.
#include <cstdio>
#include <iostream>

#include "short_rows.hpp"

using namespace gaitflow;

int main() {
  std::size_t unknowns, equal, unequal;
  std::cin >> unknowns >> equal >> unequal;
  const std::size_t rows = equal + unequal;
  const auto numbers = [](std::size_t count) {
    Vector read(count);
    for (double& each : read) std::cin >> each;
    return read;
  };
  const Vector hessian = numbers(unknowns * unknowns), jacobian = numbers(rows * unknowns);
  const Vector corner = numbers(rows), right = numbers(unknowns + rows);

  std::vector<JacobianEntry> entries;
  Indices unknown;
  for (std::uint32_t i = 0; i < unknowns; ++i) unknown.push_back(i);
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t i = 0; i < unknowns; ++i)
      if (jacobian[row * unknowns + i] != 0) entries.push_back({static_cast<std::uint32_t>(row * unknowns) + i, row, i});
  const std::vector<bool> is_short = find_short_rows(entries, unknown, equal, rows);
  const auto middle = std::stable_partition(entries.begin(), entries.end(),
                                            [&](const JacobianEntry& entry) { return !is_short[entry.row]; });
  const auto long_entries = static_cast<std::size_t>(middle - entries.begin());
  const ShortRows short_rows(entries, long_entries, entries.size(), unknown);

  Indices number(rows);
  std::size_t size = unknowns;
  for (std::size_t row = 0; row < rows; ++row)
    if (!is_short[row]) number[row] = size++;
  std::vector<std::pair<std::size_t, std::size_t>> places;
  Vector added, values;
  for (std::size_t i = 0; i < unknowns; ++i)
    for (std::size_t j = 0; j <= i; ++j) places.emplace_back(i, j), added.push_back(hessian[i * unknowns + j]);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    values.push_back(jacobian[entries[k].from]);
    if (k < long_entries) places.emplace_back(number[entries[k].row], entries[k].column), added.push_back(values[k]);
  }
  for (std::size_t row = 0; row < rows; ++row)
    if (!is_short[row]) places.emplace_back(number[row], number[row]), added.push_back(corner[row]);
  short_rows.places(places);
  Ldlt matrix(size, places);
  matrix.clear();
  for (std::size_t k = 0; k < added.size(); ++k) matrix.at(k) += added[k];
  short_rows.add(matrix, added.size(), values, corner);
  if (!matrix.factorise()) return 1;

  Vector solved(right.begin(), right.begin() + static_cast<std::ptrdiff_t>(unknowns)), multipliers(rows);
  solved.resize(size);
  for (std::size_t row = 0; row < rows; ++row)
    if (!is_short[row]) solved[number[row]] = right[unknowns + row];
  short_rows.reduce(values, corner, right.data() + unknowns, solved);
  matrix.solve(solved);
  for (std::size_t row = 0; row < rows; ++row)
    if (!is_short[row]) multipliers[row] = solved[number[row]];
  short_rows.multipliers(values, corner, right.data() + unknowns, solved, multipliers.data());
  for (std::size_t i = 0; i < unknowns; ++i) std::printf("%.17g\n", solved[i]);
  for (const double each : multipliers) std::printf("%.17g\n", each);
  std::printf("%zu\n", rows + unknowns - size);
}
