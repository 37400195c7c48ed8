// Points of the central path without the multipliers that follow from others there, as in gaitflow/runtime/condensed.py.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "map_data.hpp"

namespace gaitflow {

// How many numbers a condensed point has: free variables, equality rows, and variables or inequality rows with a bound.
inline std::size_t condensed_size(const Space& space) {
  std::vector<bool> bounded(space.free.size() + space.unequal.size(), false);
  for (const std::size_t place : space.below) bounded[place] = true;
  for (const std::size_t place : space.above) bounded[place] = true;
  const auto count = static_cast<std::size_t>(std::count(bounded.begin(), bounded.end(), true));
  return space.free.size() + space.equal.size() + count;
}

// The encoded point [ny] of a condensed one.
inline Vector expanded(const Space& space, double barrier, const Vector& numbers) {
  constexpr double largest_log = 40.0;
  const std::size_t free = space.free.size(), equal = space.equal.size(), values = free + space.unequal.size();
  const double infinite = std::numeric_limits<double>::infinity();
  Vector least(values, -infinite), most(values, infinite), lower(values, -infinite), upper(values, -infinite);
  const auto bound = [&](const Vector& variables, const Vector& rows, std::size_t place) {
    return place < free ? variables[space.free[place]] : rows[space.unequal[place - free]];
  };
  for (const std::size_t place : space.below) least[place] = bound(space.lower, space.lower_rows, place);
  for (const std::size_t place : space.above) most[place] = bound(space.upper, space.upper_rows, place);
  const double* number = numbers.data() + free + equal;
  const auto soft = [](double x) { return std::max(x, 0.0) + std::log1p(std::exp(-std::abs(x))); };  // log(1 + exp(x))
  for (std::size_t i = 0; i < values; ++i) {
    const bool has_lower = std::isfinite(least[i]), has_upper = std::isfinite(most[i]);
    if (!has_lower && !has_upper) continue;
    const double log = std::clamp(*number++, -largest_log, largest_log);
    if (has_lower && has_upper) {
      const double smallest = std::log(barrier / (most[i] - least[i]));
      lower[i] = smallest + soft(-log);
      upper[i] = smallest + soft(log);
    } else if (has_lower) {
      lower[i] = -log;
    } else {
      upper[i] = log;
    }
  }
  Vector point(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(free + equal));
  for (std::size_t i = free; i < values; ++i) point.push_back(std::exp(upper[i]) - std::exp(lower[i]));
  for (const std::size_t place : space.below) point.push_back(lower[place]);
  for (const std::size_t place : space.above) point.push_back(upper[place]);
  return point;
}

}  // namespace gaitflow
