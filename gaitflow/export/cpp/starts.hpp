// Where the method may start for a gait at a place, the best first: the order, barriers and limits of refine.py.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "atlas.hpp"
#include "gait_map.hpp"
#include "point.hpp"
#include "program.hpp"

namespace gaitflow {

// predicted: for this task, unit and all; then each step looks after the matrix's inertia.
struct Start {
  Point point;
  double unit, barrier;  // about the cost, the problem's, at the optimum
  bool predicted;
};

// From the prediction, with and without its multipliers, then from a node; where the atlas does not know the
// gait from the mean of its region. A start is made when it is asked for.
class Starts {
 public:
  static constexpr std::size_t most = 3;  // starts of a candidate

  // The arguments have to live as long; task [p] is the place's.
  Starts(const GaitMap& map, Program& program, const Candidate& candidate, const Vector& place, const Vector& task)
      : map_(map), program_(program), candidate_(candidate), place_(place), task_(task), atlas_(map.file().atlas) {
    known_ = candidate.sheet && atlas_.predict(*candidate.sheet, place, predicted_.point, predicted_.cost);
  }

  // The next one; false where there are no more.
  bool next(Start& start) {
    const std::size_t number = asked_++;
    if (!candidate_.sheet) {
      if (number == 0) start = from_mean();
      return number == 0;
    }
    const Sheet& sheet = *candidate_.sheet;
    if (known_ && number < 2) {
      const Point point = decoded(sheet.space, predicted_.point);
      const bool whole = number == 0;
      const double barrier = whole ? map_.file().atlas.barrier : primal_barrier;
      start = {whole ? point : primal_of(point), predicted_.cost, barrier, whole};
      return true;
    }
    if (number != (known_ ? 2u : 0u)) return false;
    // The nearest node says little that is new: the prediction is mostly its own.
    const std::vector<Prediction> nodes = atlas_.nearest(sheet, place_, 2);
    if (nodes.empty()) return false;
    start = {decoded(sheet.space, nodes.back().point), nodes.back().cost, node_barrier, false};
    return true;
  }

 private:
  // As in refine.py, where they are explained.
  static constexpr double primal_barrier = 1e-2, node_barrier = 1e-3, mean_barrier = 1e-2;
  static constexpr double least_cost = 1e-9;

  Start from_mean() {
    const Gait& gait = map_.gaits()[candidate_.gait];
    program_.evaluate_rows(gait.primal, task_);
    const double unit = std::max(program_.cost(), least_cost);
    return {split(gait.space, gait.primal, gait.multipliers_bounds, gait.multipliers_rows, unit), unit, mean_barrier,
            false};
  }

  const GaitMap& map_;
  Program& program_;
  const Candidate& candidate_;
  const Vector &place_, &task_;
  AtlasView atlas_;
  Prediction predicted_;
  bool known_;
  std::size_t asked_ = 0;
};

}  // namespace gaitflow
