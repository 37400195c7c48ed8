// The map's classifier, whichever method it is: softmax(scores / temperature), float32 as in the ONNX graph.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <variant>
#include <vector>

#include "cursor.hpp"
#include "forest.hpp"
#include "neighbours.hpp"
#include "perceptron.hpp"
#include "support_vectors.hpp"

namespace gaitflow {

struct Classifier {
  std::variant<Perceptron, Forest, SupportVectors, Neighbours> method;
  std::vector<float> smoothing;  // where the method votes [gaits], else empty: scores are log(votes + smoothing)
  float temperature;

  std::size_t gaits() const {
    return std::visit([](const auto& each) { return each.gaits(); }, method);
  }

  // One probability a gait, of values of the axes. Throws MapError where its numbers grow beyond float32.
  std::vector<float> probabilities(std::vector<float> values) const {
    std::vector<float> all = std::visit([&](const auto& each) { return each(std::move(values)); }, method);
    for (std::size_t i = 0; i < smoothing.size(); ++i) all[i] = std::log(all[i] + smoothing[i]);
    for (float& value : all) value /= temperature;
    const float most = *std::max_element(all.begin(), all.end());
    float total = 0;
    for (float& value : all) total += value = std::exp(value - most);
    if (!std::isfinite(total)) throw MapError("the classifier gives no probabilities here; export the map again");
    for (float& value : all) value /= total;
    return all;
  }
};

namespace detail {

inline Classifier read_classifier(Cursor& file, std::size_t axes) {
  Classifier classifier;
  switch (file.count(0, 3, "the classifier is of a kind that this reader does not know")) {
    case 0: classifier.method = read_perceptron(file, axes); break;
    case 1: classifier.method = read_forest(file, axes); break;
    case 2: classifier.method = read_support_vectors(file, axes); break;
    default: classifier.method = read_neighbours(file, axes);
  }
  const bool votes = classifier.method.index() == 1 || classifier.method.index() == 3;
  const std::size_t smoothed = file.count(0, 4096, "there are too many gaits");
  file.require(smoothed == (votes ? classifier.gaits() : 0), "the classifier's smoothing is not of its votes");
  classifier.smoothing = file.finite<float>(smoothed);
  for (const float each : classifier.smoothing) file.require(each > 0, "the classifier's smoothing is not positive");
  classifier.temperature = file.finite<float>(1)[0];
  file.require(classifier.temperature > 0, "the classifier's temperature is not positive");
  return classifier;
}

}  // namespace detail

}  // namespace gaitflow
