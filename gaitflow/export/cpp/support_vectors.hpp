// A classifier of support vector machines with radial-basis kernels, one a gait.
#pragma once

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "cursor.hpp"
#include "scaler.hpp"

namespace gaitflow {

struct Machine {
  float gamma, bias;
  std::vector<float> coefficients, vectors;  // [n], [n, axes]

  float score(const std::vector<float>& values) const {
    double total = 0;
    const float* vector = vectors.data();
    for (const float coefficient : coefficients) {
      float distance = 0;
      for (const float value : values) {
        const float difference = value - *vector++;
        distance += difference * difference;
      }
      total += coefficient * std::exp(-gamma * distance);
    }
    return static_cast<float>(total + bias);
  }
};

// One machine alone gives the scores (-score, score) of two gaits.
struct SupportVectors {
  Scaler scaler;
  std::vector<Machine> machines;

  std::size_t gaits() const { return machines.size() == 1 ? 2 : machines.size(); }

  // A score a gait, of values of the axes.
  std::vector<float> operator()(std::vector<float> values) const {
    scaler.apply(values);
    std::vector<float> scores;
    for (const Machine& machine : machines) scores.push_back(machine.score(values));
    if (machines.size() == 1) scores.insert(scores.begin(), -scores[0]);
    return scores;
  }
};

namespace detail {

inline SupportVectors read_support_vectors(Cursor& file, std::size_t axes) {
  SupportVectors all;
  all.scaler = read_scaler(file, axes);
  const std::size_t machines = file.count(1, 4096, "there are no support vector machines, or too many");
  for (std::size_t i = 0; i < machines; ++i) {
    Machine machine;
    const std::size_t vectors = file.count(1, 100000000, "a machine has no support vectors, or too many");
    const std::vector<float> constants = file.finite<float>(2);
    machine.gamma = constants[0], machine.bias = constants[1];
    file.require(machine.gamma > 0, "the width of a kernel is not positive");
    machine.coefficients = file.finite<float>(vectors);
    machine.vectors = file.finite<float>(vectors * axes);
    all.machines.push_back(std::move(machine));
  }
  return all;
}

}  // namespace detail

}  // namespace gaitflow
