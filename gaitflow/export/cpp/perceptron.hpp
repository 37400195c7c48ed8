// A classifier of layers: weights * values + biases, between two of them negative values become 0.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "cursor.hpp"

namespace gaitflow {

struct Layer {
  std::size_t outputs, inputs;
  std::vector<float> weights, biases;  // [inputs, outputs], [outputs]
};

struct Perceptron {
  std::vector<Layer> layers;

  std::size_t gaits() const { return layers.back().outputs; }

  // A score a gait, of values of the axes.
  std::vector<float> operator()(std::vector<float> values) const {
    std::vector<float> next;
    for (const Layer& layer : layers) {
      next = layer.biases;
      const float* weight = layer.weights.data();
      for (const float value : values)
        for (float& sum : next) sum += *weight++ * value;
      if (&layer != &layers.back())
        for (float& value : next) value = std::max(value, 0.0f);
      values.swap(next);
    }
    return values;
  }
};

namespace detail {

inline Perceptron read_perceptron(Cursor& file, std::size_t axes) {
  Perceptron perceptron;
  const std::size_t layers = file.count(1, 100, "the classifier has no layers, or too many");
  for (std::size_t i = 0; i < layers; ++i) {
    Layer layer;
    layer.outputs = file.count(1, 100000, "a layer of the classifier is empty or too large");
    layer.inputs = file.count(1, 100000, "a layer of the classifier is empty or too large");
    const std::size_t inputs = i == 0 ? axes : perceptron.gaits();
    file.require(layer.inputs == inputs, "the layers of the classifier do not fit together");
    layer.weights = file.finite<float>(layer.outputs * layer.inputs);
    layer.biases = file.finite<float>(layer.outputs);
    perceptron.layers.push_back(std::move(layer));
  }
  return perceptron;
}

}  // namespace detail

}  // namespace gaitflow
