// The scaler in front of a forest and of support vectors.
#pragma once

#include <cstddef>
#include <vector>

#include "cursor.hpp"

namespace gaitflow {

// Of each axis: (value - offset) * scale.
struct Scaler {
  std::vector<float> offset, scale;

  void apply(std::vector<float>& values) const {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = (values[i] - offset[i]) * scale[i];
  }
};

namespace detail {

inline Scaler read_scaler(Cursor& file, std::size_t axes) {
  Scaler scaler;
  scaler.offset = file.finite<float>(axes);
  scaler.scale = file.finite<float>(axes);
  return scaler;
}

}  // namespace detail

}  // namespace gaitflow
