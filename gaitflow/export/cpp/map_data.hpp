// What map.bin holds. Numbers are little-endian in the file; arrays here are as there, row by row.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "classifier.hpp"

namespace gaitflow {

using Vector = std::vector<double>;

// The parameters of a task, as the exported functions take them, with the values that the map holds them at; of those
// that it ranges over, its axes, `ranged` has the place among the parameters.
struct Task {
  std::vector<std::string> names;
  Vector held;
  std::vector<std::size_t> ranged;
};

// Tasks of a grid, over which the map answers: values of every axis, rising; feasible has the last axis fastest.
struct Domain {
  std::vector<Vector> axes;
  std::vector<unsigned char> feasible;
};

// Sizes of the decision vector w = (x_0, u_0, x_1, ..., x_K, end forces, phase durations, contacts), and w * scale in
// SI units for a cycle of 1 s. Only where forces are linear there are end forces, those at the end of each phase; only
// where the objective is energy there are contacts, a leg in a phase each, which bounds fix.
struct Layout {
  std::size_t phases, knots_per_phase, dimension, base, rows;
  bool linear_forces, energy;
  std::vector<std::string> legs;
  Vector shares;  // what part of its phase each step lasts [knots_per_phase]
  Vector scale;

  std::size_t steps() const { return phases * knots_per_phase; }
  std::size_t feet() const { return legs.size() * dimension; }
  std::size_t ends() const { return linear_forces ? phases * feet() : 0; }
  std::size_t contacts() const { return energy ? phases * legs.size() : 0; }
  std::size_t variables() const {
    return (steps() + 1) * (base + feet()) + steps() * 2 * feet() + ends() + phases + contacts();
  }
};

// The bounds that impose a pattern, of variables [nw] and rows [ng], and what they leave free.
struct Space {
  Vector lower, upper, lower_rows, upper_rows;
  std::vector<std::size_t> free, equal, unequal;  // variables, equality rows, inequality rows
  std::vector<std::size_t> below, above;          // which of (free, unequal) have a bound below, above

  std::size_t encoded() const { return free.size() + equal.size() + unequal.size() + below.size() + above.size(); }
};

struct Gait {
  std::string name, key, pattern;
  Vector primal, multipliers_bounds, multipliers_rows;  // means of the gait's region
  Space space;
};

// One pattern of a gait: n solved tasks (nodes) over a axes, each a point of k modes, with derivatives by the axes. Points
// have c numbers, condensed ones or encoded.
// Lengths are in steps of the axes, slopes and tangents are by such a step.
struct Sheet {
  std::size_t gait;
  std::string pattern;
  Space space;
  double tear;
  std::size_t nodes, mode_count, infeasible_count;
  Vector places, log_costs, slopes;              // [n, a], [n], [n, a]
  Vector infeasible;                             // [m, a]: places where the pattern has no motion
  std::vector<float> mean, modes, coordinates;   // [c], [k, c], [n, k]
  Vector tangents;                               // [n, a, k]
  std::vector<std::size_t> by_first_axis;        // the nodes in the order of their first axis
};

// The constants of the rule by which nodes predict are those of gaitflow/runtime/atlas.py, in steps.
struct Atlas {
  Vector steps;
  double barrier, reach, nearest, support, doubt;
  std::vector<Sheet> sheets;
};

struct MapFile {
  std::string scenario, version;
  std::array<unsigned char, 32> manifest_sha256;
  Task task;
  Domain domain;
  Layout layout;
  Classifier classifier;
  double cost_scale;  // times the problem's cost: that in the scenario's units
  std::vector<Gait> gaits;
  Atlas atlas;
};

}  // namespace gaitflow
