// Primal-dual points of a gait: of vectors that the problem takes, and of the numbers that the atlas predicts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "map_data.hpp"

namespace gaitflow {

// Of a cost that is divided by a unit. free [nF]: the variables that the gait leaves free; rows [nE + nI]: multipliers
// of the equality, then of the inequality rows; lower, upper [nF + nI]: multipliers, 0 or more, of the bounds of the free
// variables and of the inequality rows, 0 where there is none.
struct Point {
  Vector free, rows, lower, upper;
};

// Of a point as the atlas has it [ny]: those of bounds are logarithms.
inline Point decoded(const Space& space, const Vector& numbers) {
  constexpr double largest_log = 20.0;
  const std::size_t free = space.free.size(), rows = space.equal.size() + space.unequal.size();
  const std::size_t bounded = free + space.unequal.size();
  const double* number = numbers.data();
  Point point{Vector(number, number + free), Vector(number + free, number + free + rows), Vector(bounded, 0.0),
              Vector(bounded, 0.0)};
  number += free + rows;
  for (const std::size_t place : space.below) point.lower[place] = std::exp(std::min(*number++, largest_log));
  for (const std::size_t place : space.above) point.upper[place] = std::exp(std::min(*number++, largest_log));
  return point;
}

// Of a decision vector [nw] and multipliers of bounds [nw] and rows [ng], of any cost (CasADi's signs).
inline Point split(const Space& space, const Vector& primal, const Vector& bounds, const Vector& rows, double unit) {
  const std::size_t free = space.free.size(), bounded = free + space.unequal.size();
  Point point{{}, {}, Vector(bounded, 0.0), Vector(bounded, 0.0)};
  for (const std::size_t i : space.free) point.free.push_back(primal[i]);
  for (const std::size_t i : space.equal) point.rows.push_back(rows[i] / unit);
  for (const std::size_t i : space.unequal) point.rows.push_back(rows[i] / unit);
  const auto push = [&](std::size_t i) {
    return (i < free ? bounds[space.free[i]] : rows[space.unequal[i - free]]) / unit;
  };
  for (const std::size_t i : space.below) point.lower[i] = std::max(-push(i), 0.0);
  for (const std::size_t i : space.above) point.upper[i] = std::max(push(i), 0.0);
  return point;
}

// Free variables [nF] without multipliers: those of bounds follow from the barrier.
inline Point primal_of(const Space& space, const Vector& free) {
  const std::size_t bounded = space.free.size() + space.unequal.size();
  return {free, Vector(space.equal.size() + space.unequal.size(), 0.0), Vector(bounded, 0.0), Vector(bounded, 0.0)};
}

}  // namespace gaitflow
