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

// careful: each step looks after the matrix's inertia, as a start allows that is of this very task.
struct Start {
  Point point;
  double unit, barrier;  // about the cost, the problem's, at the optimum
  bool careful;
};

// From the prediction, with and without its multipliers; from a node; from the nominal start, which over many axes comes
// first. Where the atlas does not know the gait, from the mean of its region. A start is made when it is asked for.
class Starts {
 public:
  // The arguments have to live as long; task [p] is the place's.
  Starts(const GaitMap& map, Program& program, const Candidate& candidate, const Vector& place, const Vector& task)
      : map_(map), program_(program), candidate_(candidate), place_(place), task_(task), atlas_(map.file().atlas) {
    if (!candidate.sheet) {
      left_ = {Kind::mean};
      return;
    }
    const bool is_wide = place.size() > AtlasView::near_axes;
    if (is_wide) left_.push_back(Kind::nominal);
    if (atlas_.predict(*candidate.sheet, place, predicted_.point, predicted_.cost)) {
      left_.insert(left_.end(), {Kind::prediction, Kind::primal});
    } else {
      predicted_.cost = node(1).cost;
    }
    left_.push_back(Kind::node);
    if (!is_wide) left_.push_back(Kind::nominal);
  }

  // The next one; false where there are no more.
  bool next(Start& start) {
    if (asked_ == left_.size()) return false;
    start = made(left_[asked_++]);
    return true;
  }

 private:
  enum class Kind { mean, nominal, prediction, primal, node };

  // As in starts.py, where they are explained.
  static constexpr double primal_barrier = 1e-2, node_barrier = 1e-3, nominal_barrier = 1e-2, mean_barrier = 1e-2;
  static constexpr double least_cost = 1e-9;

  Start made(Kind kind) {
    if (kind == Kind::mean) return from_mean();
    const Space& space = candidate_.sheet->space;
    if (kind == Kind::nominal)
      return {primal_of(space, nominal_free(space)), predicted_.cost, nominal_barrier, true};
    if (kind == Kind::node) {
      // The nearest node says little that is new: the prediction is mostly its own.
      const Prediction second = node(2);
      return {decoded(space, second.point), second.cost, node_barrier, false};
    }
    const Point point = decoded(space, predicted_.point);
    if (kind == Kind::prediction) return {point, predicted_.cost, map_.file().atlas.barrier, true};
    return {primal_of(space, point.free), predicted_.cost, primal_barrier, false};
  }

  // The free variables [nF] of the nominal start.
  Vector nominal_free(const Space& space) {
    const Vector& w = program_.nominal(task_);
    Vector free;
    for (const std::size_t i : space.free) free.push_back(w[i]);
    return free;
  }

  // The last of the `count` nodes nearest to the place.
  Prediction node(std::size_t count) const { return atlas_.nearest(*candidate_.sheet, place_, count).back(); }

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
  Prediction predicted_;  // without a point where nobody knows one
  std::vector<Kind> left_;
  std::size_t asked_ = 0;
};

}  // namespace gaitflow
