// What map.bin holds. Numbers are little-endian in the file; arrays here are as there, row by row.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace gaitflow {

using Vector = std::vector<double>;

// Sizes of the decision vector w = (x_0, u_0, x_1, ..., x_K, phase durations), and w * scale in SI units.
struct Layout {
  std::size_t phases, knots_per_phase, dimension, base, rows;
  std::vector<std::string> legs;
  Vector scale;

  std::size_t steps() const { return phases * knots_per_phase; }
  std::size_t feet() const { return legs.size() * dimension; }
  std::size_t variables() const { return (steps() + 1) * (base + feet()) + steps() * 2 * feet() + phases; }
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

struct Layer {
  std::size_t outputs, inputs;
  std::vector<float> weights, biases;  // [inputs, outputs], [outputs]
};

// One full pattern of a gait over the atlas' tasks: n nodes, each a point of k modes.
struct Sheet {
  std::size_t gait;
  std::string pattern;
  Space space;
  double tear;
  std::vector<std::uint32_t> places;             // [n, 2] indices on the atlas' axes
  Vector log_costs;                              // [n]
  std::vector<float> mean, modes, coordinates;   // [ny], [k, ny], [n, k]
  std::size_t mode_count;
  std::vector<std::int32_t> node_at;             // [speeds, cycle durations]: number of the node there, -1 for none
};

struct MapFile {
  std::string scenario, version;
  std::array<unsigned char, 32> manifest_sha256;
  Vector speeds, cycle_durations;       // the domain's axes [m/s], [s]
  std::vector<unsigned char> feasible;  // [speeds, cycle durations]
  Layout layout;
  std::vector<Layer> layers;
  float temperature;
  std::vector<Gait> gaits;
  Vector atlas_speeds, atlas_cycle_durations;
  double barrier;
  std::vector<Sheet> sheets;
};

}  // namespace gaitflow
