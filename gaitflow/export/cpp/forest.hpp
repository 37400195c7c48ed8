// A classifier of trees, whose leaves vote for gaits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cursor.hpp"
#include "scaler.hpp"

namespace gaitflow {

// A node leads to `below` where the value on its axis is at most its threshold, else to `above`. What is smaller than
// the number of nodes is a node, the rest are leaves. One column of votes v stands for (1 - v, v) of two gaits.
struct Forest {
  Scaler scaler;
  std::vector<std::uint32_t> roots;  // one a tree
  std::vector<std::uint32_t> axis, below, above;
  std::vector<float> threshold;
  std::size_t columns;
  std::vector<float> votes;  // [leaves, columns]

  std::size_t gaits() const { return columns == 1 ? 2 : columns; }

  // The votes for each gait, of values of the axes.
  std::vector<float> operator()(std::vector<float> values) const {
    scaler.apply(values);
    std::vector<float> total(columns, 0.0f);
    for (std::size_t place : roots) {
      while (place < axis.size()) place = values[axis[place]] <= threshold[place] ? below[place] : above[place];
      const float* row = votes.data() + (place - axis.size()) * columns;
      for (float& sum : total) sum += *row++;
    }
    if (columns == 1) total.insert(total.begin(), 1.0f - total[0]);
    return total;
  }
};

namespace detail {

inline Forest read_forest(Cursor& file, std::size_t axes) {
  const char *size = "a forest is empty or too large", *fault = "a tree of the forest leads nowhere";
  Forest forest;
  forest.scaler = read_scaler(file, axes);
  const std::size_t trees = file.count(1, 100000, size), nodes = file.count(0, 100000000, size);
  const std::size_t leaves = file.count(1, 100000000, size);
  forest.columns = file.count(1, 4096, size);
  forest.roots = file.places(trees, nodes + leaves, fault);
  forest.axis = file.places(nodes, axes, "a tree of the forest asks for an axis that the map has not");
  forest.threshold = file.finite<float>(nodes);
  forest.below = file.places(nodes, nodes + leaves, fault);
  forest.above = file.places(nodes, nodes + leaves, fault);
  // So that every way ends.
  for (std::size_t i = 0; i < nodes; ++i)
    file.require(forest.below[i] > i && forest.above[i] > i, "a tree of the forest leads back");
  forest.votes = file.finite<float>(leaves * forest.columns);
  for (const float vote : forest.votes) file.require(vote >= 0, "a vote of the forest is negative");
  return forest;
}

}  // namespace detail

}  // namespace gaitflow
