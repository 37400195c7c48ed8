// Newton's method along the central path of a gait's problem, as gaitflow/solvers/interior_point.py.
//
// From a predicted point of the path a few Newton steps with a falling barrier reach the optimum. There is no line
// search: what does not converge is lost, and somebody else's to try.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "kkt.hpp"
#include "map_data.hpp"
#include "point.hpp"
#include "program.hpp"

namespace gaitflow {

// infeasible: rows are far from met and their multipliers say that they cannot be met, which is evidence from one start
// and no proof; lost: numbers or the matrix gave out; limit: of iterations.
enum class Ending { converged, infeasible, lost, limit };

struct Outcome {
  Ending ending;
  std::size_t iterations;
  double cost;  // the program's
};

// The larger absolute value; NaN where either is, unlike std::max, so that a lost residual is not forgotten.
inline double larger(double most, double value) {
  return std::abs(value) <= most || std::isnan(most) ? most : std::abs(value);
}

// The problem of one gait in that gait's space. For one thread; takes memory only when it is made.
class InteriorPoint {
 public:
  InteriorPoint(Program& program, const Space& space)
      : program_(program),
        space_(space),
        kkt_(program, space),
        free_(space.free.size()),
        equal_(space.equal.size()),
        bounded_(free_ + space.unequal.size()),
        rows_(equal_ + space.unequal.size()),
        least_(bounded_, -infinity),
        most_(bounded_, infinity),
        w_(fixed_variables(space)),
        multipliers_(space.lower_rows.size(), 0.0),
        values_(bounded_),
        to_lower_(bounded_, 1.0),
        to_upper_(bounded_, 1.0),
        slope_(bounded_),
        off_(rows_),
        stiffness_(bounded_),
        force_(bounded_),
        variables_(free_),
        softness_(bounded_ - free_),
        right_(free_ + rows_),
        step_(free_ + rows_),
        moved_(bounded_),
        lower_step_(bounded_),
        upper_step_(bounded_) {
    for (const std::size_t i : space.below)
      least_[i] = i < free_ ? space.lower[space.free[i]] : space.lower_rows[space.unequal[i - free_]];
    for (const std::size_t i : space.above)
      most_[i] = i < free_ ? space.upper[space.free[i]] : space.upper_rows[space.unequal[i - free_]];
  }

  // To the optimum at a task [p] from a point near the central path at `barrier`, in `limit` iterations at most. unit is
  // about the cost at the optimum; the start's multipliers belong to cost / unit. careful: every step is taken with a
  // matrix of the right inertia.
  Outcome follow(const Vector& task, const Point& start, double unit, double barrier, std::size_t limit, bool careful) {
    const double end = gap / static_cast<double>(space_.below.size() + space_.above.size());
    double length = 1.0;
    kkt_.last_lift = 0;
    enter(task, start, barrier);
    for (std::size_t iteration = 0;; ++iteration) {
      evaluate(task);
      measure(unit);
      const auto ended = [&](Ending ending) { return Outcome{ending, iteration, program_.cost()}; };
      if (converged()) return ended(Ending::converged);
      if (!std::isfinite(row_ + dual_) || row_ > largest_row) return ended(Ending::lost);
      if (iteration >= early && row_ > nearly_met && out_of_bounds(unit)) return ended(Ending::infeasible);
      if (iteration == limit) return ended(Ending::limit);
      if (iteration == 0 || std::max(row_, dual_) < near)
        barrier = std::max(end, std::min(0.1 * barrier, std::pow(barrier, 1.5)));
      if (!find_step(task, unit, barrier, careful || length < short_step)) return ended(Ending::lost);
      length = take_step(barrier);
    }
  }

  // Where the last run ended [nw].
  const Vector& w() const { return w_; }
  const Space& space() const { return space_; }
  const Kkt& kkt() const { return kkt_; }

 private:
  static constexpr double infinity = std::numeric_limits<double>::infinity();
  // As in interior_point.py, where each of them is explained.
  static constexpr double row_limit = 5e-7, cost_limit = 1e-5, dual_limit = 1e-5, gap = 3e-6, largest_row = 1e4;
  static constexpr double nearest = 1e-15, near = 1e-2, least_stiffness = 1e-14, held = 1e-3, short_step = 0.3;
  static constexpr double largest_multiplier = 2e3, unmet = 2e-2, largest_of_all = 5e5, nearly_met = 5e-4;
  static constexpr std::size_t early = 10;

  // Values of free variables and inequality rows inside their bounds, and multipliers that fit.
  void enter(const Vector& task, const Point& start, double barrier) {
    for (std::size_t i = 0; i < free_; ++i) w_[space_.free[i]] = start.free[i];
    program_.evaluate_rows(w_, task);
    for (std::size_t i = 0; i < bounded_; ++i)
      values_[i] = i < free_ ? start.free[i] : program_.rows()[space_.unequal[i - free_]];
    const auto inside = [&](std::size_t i, double push) {
      const double width = most_[i] - least_[i];  // infinite with one bound only
      return 0.2 * std::min(barrier / std::max(push, barrier), 0.1 * width);
    };
    for (const std::size_t i : space_.below) values_[i] = std::max(values_[i], least_[i] + inside(i, start.lower[i]));
    for (const std::size_t i : space_.above) values_[i] = std::min(values_[i], most_[i] - inside(i, start.upper[i]));
    point_ = start;
    const auto fitting = [barrier](double push, double distance) {
      return std::min(std::max(push, 0.1 * barrier / distance), 10 * barrier / distance);
    };
    for (const std::size_t i : space_.below) point_.lower[i] = fitting(start.lower[i], values_[i] - least_[i]);
    for (const std::size_t i : space_.above) point_.upper[i] = fitting(start.upper[i], most_[i] - values_[i]);
  }

  void evaluate(const Vector& task) {
    for (std::size_t i = 0; i < free_; ++i) w_[space_.free[i]] = values_[i];
    program_.evaluate_rows(w_, task);
    program_.evaluate_slopes(w_, task);
  }

  // How far the point is from the optimality conditions.
  void measure(double unit) {
    kkt_.transposed_jacobian(point_.rows, slope_);
    slope_.resize(bounded_);
    for (std::size_t i = 0; i < free_; ++i) slope_[i] += program_.gradient()[space_.free[i]] / unit;
    for (std::size_t i = free_; i < bounded_; ++i) slope_[i] = -point_.rows[equal_ + i - free_];
    for (std::size_t i = 0; i < equal_; ++i)
      off_[i] = program_.rows()[space_.equal[i]] - space_.lower_rows[space_.equal[i]];
    for (std::size_t i = equal_; i < rows_; ++i)
      off_[i] = program_.rows()[space_.unequal[i - equal_]] - values_[free_ + i - equal_];
    for (const std::size_t i : space_.below) to_lower_[i] = std::max(values_[i] - least_[i], nearest);
    for (const std::size_t i : space_.above) to_upper_[i] = std::max(most_[i] - values_[i], nearest);
    row_ = dual_ = products_ = cost_ = 0;
    for (std::size_t i = 0; i < rows_; ++i) row_ = larger(row_, off_[i]), cost_ += off_[i] * point_.rows[i];
    for (std::size_t i = 0; i < bounded_; ++i) dual_ = larger(dual_, slope_[i] - (point_.lower[i] - point_.upper[i]));
    for (const std::size_t i : space_.below) products_ += point_.lower[i] * to_lower_[i];
    for (const std::size_t i : space_.above) products_ += point_.upper[i] * to_upper_[i];
  }

  // Nothing but rows is left to be done.
  bool optimal() const { return dual_ <= dual_limit && products_ <= 3 * gap; }

  bool converged() const { return row_ <= row_limit && std::abs(cost_) <= cost_limit && optimal(); }

  // Multipliers of rows without a solution grow without end.
  bool out_of_bounds(double unit) const {
    const double at_most = row_ > unmet ? largest_multiplier : largest_of_all;
    const double most = at_most * std::max(1.0, std::abs(program_.cost()) / unit);
    return std::any_of(point_.rows.begin(), point_.rows.end(), [most](double each) { return std::abs(each) > most; });
  }

  // One Newton step towards the central path at `barrier`; false where the matrix has no factorisation. `correct` looks
  // after its eigenvalues.
  bool find_step(const Vector& task, double unit, double barrier, bool correct) {
    for (std::size_t i = 0; i < equal_; ++i) multipliers_[space_.equal[i]] = point_.rows[i] * unit;
    for (std::size_t i = equal_; i < rows_; ++i) multipliers_[space_.unequal[i - equal_]] = point_.rows[i] * unit;
    program_.evaluate_hessian(w_, task, multipliers_);
    std::fill(stiffness_.begin(), stiffness_.end(), 0.0);
    force_ = slope_;
    for (const std::size_t i : space_.below)
      stiffness_[i] += point_.lower[i] / to_lower_[i], force_[i] -= barrier / to_lower_[i];
    for (const std::size_t i : space_.above)
      stiffness_[i] += point_.upper[i] / to_upper_[i], force_[i] += barrier / to_upper_[i];
    const double hold = optimal() ? held : 0.0;
    for (std::size_t i = 0; i < free_; ++i) variables_[i] = stiffness_[i] + hold, right_[i] = -force_[i];
    for (std::size_t i = 0; i < rows_; ++i) right_[free_ + i] = -off_[i];
    for (std::size_t i = free_; i < bounded_; ++i) {
      softness_[i - free_] = 1 / (stiffness_[i] + least_stiffness);
      right_[equal_ + i] -= force_[i] * softness_[i - free_];
    }
    if (!kkt_.factorise(unit, variables_, softness_, correct)) return false;
    kkt_.solve(right_, step_);
    std::copy_n(step_.begin(), free_, moved_.begin());
    for (std::size_t i = free_; i < bounded_; ++i) moved_[i] = (step_[equal_ + i] - force_[i]) * softness_[i - free_];
    for (const std::size_t i : space_.below)
      lower_step_[i] = (barrier - point_.lower[i] * moved_[i]) / to_lower_[i] - point_.lower[i];
    for (const std::size_t i : space_.above)
      upper_step_[i] = (barrier + point_.upper[i] * moved_[i]) / to_upper_[i] - point_.upper[i];
    return true;
  }

  // Takes the step, shortened to stay inside the bounds; how short it became.
  double take_step(double barrier) {
    const double keep = std::max(0.99, 1 - barrier);
    double primal = 1.0, dual = 1.0;
    for (const std::size_t i : space_.below) {
      if (moved_[i] < 0) primal = std::min(primal, -keep * to_lower_[i] / moved_[i]);
      if (lower_step_[i] < 0) dual = std::min(dual, -keep * point_.lower[i] / lower_step_[i]);
    }
    for (const std::size_t i : space_.above) {
      if (moved_[i] > 0) primal = std::min(primal, keep * to_upper_[i] / moved_[i]);
      if (upper_step_[i] < 0) dual = std::min(dual, -keep * point_.upper[i] / upper_step_[i]);
    }
    for (std::size_t i = 0; i < bounded_; ++i) values_[i] += primal * moved_[i];
    for (std::size_t i = 0; i < rows_; ++i) point_.rows[i] += primal * step_[free_ + i];
    for (const std::size_t i : space_.below) point_.lower[i] += dual * lower_step_[i];
    for (const std::size_t i : space_.above) point_.upper[i] += dual * upper_step_[i];
    return std::min(primal, dual);
  }

  Program& program_;
  const Space& space_;
  Kkt kkt_;
  std::size_t free_, equal_, bounded_, rows_;  // nF, nE, nF + nI, nE + nI
  Vector least_, most_;                        // bounds [nF + nI], infinite where there is none
  Vector w_, multipliers_;                     // [nw], [ng]
  Vector values_;                              // of free variables and inequality rows [nF + nI]
  Point point_;                                // its multipliers; `values_` has its variables
  Vector to_lower_, to_upper_;                 // distances to the bounds [nF + nI], 1 where there is none
  Vector slope_;                               // of the Lagrangian without the bounds' part [nF + nI]
  Vector off_;                                 // the rows' errors [nE + nI]
  double row_ = 0, dual_ = 0, products_ = 0, cost_ = 0;
  Vector stiffness_, force_, variables_, softness_, right_, step_, moved_, lower_step_, upper_step_;
};

}  // namespace gaitflow
