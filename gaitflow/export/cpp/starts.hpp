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
  std::size_t limit;     // of iterations
  bool predicted;
};

// From the prediction, with and without its multipliers, then from the nearest nodes; where the atlas does not know the
// gait from the mean of its region. A start is made when it is asked for.
class Starts {
 public:
  static constexpr std::size_t most = 4;

  // The arguments have to live as long; task [p] is the place's.
  Starts(const GaitMap& map, Program& program, const Candidate& candidate, const Vector& place, const Vector& task)
      : map_(map), program_(program), candidate_(candidate), place_(place), task_(task), atlas_(map.file().atlas) {
    known_ = candidate.sheet && atlas_.predict(*candidate.sheet, place, predicted_.point, predicted_.cost);
  }

  // The cost that is predicted, the problem's; false where nothing is.
  bool predicted(double& cost) const {
    cost = predicted_.cost;
    return known_;
  }

  // The next one; false where there are no more.
  bool next(Start& start) {
    const std::size_t number = asked_++;
    if (!candidate_.sheet) {
      if (number == 0) start = from_mean();
      return number == 0;
    }
    const Space& space = candidate_.sheet->space;
    if (known_ && number == 0) {
      start = {decoded(space, predicted_.point), predicted_.cost, map_.file().atlas.barrier,
               predicted_limit, true};
      return true;
    }
    if (known_ && number == 1) {
      start = {primal_of(decoded(space, predicted_.point)), predicted_.cost, primal_barrier, primal_limit,
               false};
      return true;
    }
    const std::size_t node = number - (known_ ? 2 : 0);
    if (node == 0) nodes_ = atlas_.nearest(*candidate_.sheet, place_, nearest_nodes);
    if (node >= nodes_.size()) return false;
    start = {decoded(space, nodes_[node].point), nodes_[node].cost, node_barrier, node_limit, false};
    return true;
  }

 private:
  // As in refine.py, where they are explained.
  static constexpr std::size_t predicted_limit = 25, primal_limit = 30, node_limit = 25, mean_limit = 30;
  static constexpr double primal_barrier = 1e-2, node_barrier = 1e-3, mean_barrier = 1e-2;
  static constexpr std::size_t nearest_nodes = 2;
  static constexpr double least_cost = 1e-9;

  Start from_mean() {
    const Gait& gait = map_.gaits()[candidate_.gait];
    program_.evaluate_rows(gait.primal, task_);
    const double unit = std::max(program_.cost(), least_cost);
    return {split(gait.space, gait.primal, gait.multipliers_bounds, gait.multipliers_rows, unit), unit, mean_barrier,
            mean_limit, false};
  }

  const GaitMap& map_;
  Program& program_;
  const Candidate& candidate_;
  const Vector &place_, &task_;
  AtlasView atlas_;
  Prediction predicted_;
  bool known_;
  std::vector<Prediction> nodes_;
  std::size_t asked_ = 0;
};

}  // namespace gaitflow
