// The KKT matrix of one gait: one sparsity, one order, one symbolic factorisation, however often it is solved.
//
//     [ H + D_w      J_E^T      J_I^T    ]   variables that the gait leaves free [nF]
//     [ J_E         -d                   ]   equality rows [nE]
//     [ J_I                     -D_I     ]   inequality rows [nI], their slacks eliminated
//
// As gaitflow/solvers/kkt.py, but smaller: variables that move together are one unknown, the rows that join them none,
// and inequality rows that few variables meet are part of H.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "ldlt.hpp"
#include "map_data.hpp"
#include "paths.hpp"
#include "program.hpp"
#include "short_rows.hpp"

namespace gaitflow {

// The variables [nw] with those that a gait fixes at their values, 0 elsewhere.
inline Vector fixed_variables(const Space& space) {
  Vector w(space.lower);
  for (const std::size_t i : space.free) w[i] = 0;
  return w;
}

// For one thread; takes memory only when it is made.
class Kkt {
 public:
  Kkt(Program& program, const Space& space)
      : program_(program), free_(space.free.size()), equal_(space.equal.size()), rows_(equal_ + space.unequal.size()) {
    find_entries(space);
    groups_ = paths_.groups(free_);
    for (const std::size_t group : groups_) unknowns_ = std::max(unknowns_, group + 1);
    std::vector<bool> joins(rows_, false), moves(free_, false);
    for (const PathNode& node : paths_.nodes()) {
      moves[node.variable] = true;
      if (node.sign != 0) joins[node.row] = true;
    }
    const std::vector<bool> is_short = find_short_rows(jacobian_, groups_, equal_, rows_);
    for (std::size_t row = 0; row < rows_; ++row) {
      if (!joins[row]) kept_.push_back(row);
      if (!joins[row] && !is_short[row]) in_matrix_.push_back(row);
    }
    for (std::size_t k = 0; k < hessian_.size(); ++k) {
      const HessianEntry& entry = hessian_[k];
      if (groups_[entry.top] == groups_[entry.left] && entry.top != entry.left) twice_.push_back(k);
      if (moves[entry.top] || moves[entry.left]) hessian_of_paths_.push_back(k);
    }
    const auto place = [&](const JacobianEntry& entry) {
      return joins[entry.row] ? rows_ + 1 : is_short[entry.row] ? 1 + entry.row : 0;
    };
    std::stable_sort(jacobian_.begin(), jacobian_.end(),
                     [&](const auto& one, const auto& other) { return place(one) < place(other); });
    std::size_t kept = 0;
    for (const JacobianEntry& entry : jacobian_) entries_in_matrix_ += place(entry) == 0, kept += !joins[entry.row];
    short_rows_ = ShortRows(jacobian_, entries_in_matrix_, kept, groups_);
    for (std::size_t k = 0; k < kept; ++k)
      if (moves[jacobian_[k].column]) jacobian_of_paths_.push_back(k);
    hessian_values_.resize(hessian_.size()), jacobian_values_.resize(jacobian_.size());
    build();
    diagonal_.resize(free_), offsets_.resize(free_), sums_.resize(free_);
    row_sums_.resize(rows_), reduced_.resize(free_ + rows_), joined_.resize(ldlt_.size());
    corner_.assign(rows_, 0.0), left_.resize(free_ + rows_), correction_.resize(free_ + rows_);
  }

  double last_lift = 0;  // what H's diagonal was raised by; to be set to 0 where a run begins

  // J^T * multipliers [nF] at the program's last slopes; multipliers [nE + nI], equality rows first.
  void transposed_jacobian(const Vector& multipliers, Vector& product) const {
    product.assign(free_, 0.0);
    const Vector& values = program_.jacobian();
    for (const JacobianEntry& entry : jacobian_) product[entry.column] += values[entry.from] * multipliers[entry.row];
  }

  // Factorise it with the program's Hessian over `unit`, D_w = variables [nF] and D_I = unequal [nI]. `correct`: raise
  // H's diagonal until there are as many negative pivots as rows in it, as at a minimum. False where that fails.
  bool factorise(double unit, const Vector& variables, const Vector& unequal, bool correct) {
    const Vector &hessian = program_.hessian(), &jacobian = program_.jacobian();
    const double scale = 1 / unit;
    for (std::size_t k = 0; k < hessian_.size(); ++k) hessian_values_[k] = hessian[hessian_[k].from] * scale;
    for (std::size_t k = 0; k < jacobian_.size(); ++k) jacobian_values_[k] = jacobian[jacobian_[k].from];
    for (const std::size_t row : kept_) corner_[row] = row < equal_ ? -dual : -unequal[row - equal_] - dual;
    double lift = primal, raised = std::max(least_lift, last_lift / 3);
    for (int tried = 0; tried < corrections; ++tried) {
      std::size_t place = 0;
      ldlt_.clear();
      for (const double value : hessian_values_) ldlt_.at(place++) += value;
      for (const std::size_t k : twice_) ldlt_.at(k) += hessian_values_[k];
      for (std::size_t k = 0; k < entries_in_matrix_; ++k) ldlt_.at(place++) += jacobian_values_[k];
      for (std::size_t i = 0; i < free_; ++i) ldlt_.at(place++) += diagonal_[i] = variables[i] + lift;
      for (const std::size_t row : in_matrix_) ldlt_.at(place++) += corner_[row];
      short_rows_.add(ldlt_, place, jacobian_values_, corner_);
      if (ldlt_.factorise() && (!correct || ldlt_.signs() == std::make_pair(in_matrix_.size(), unknowns_))) {
        last_lift = lift > primal ? lift : last_lift / 10;
        return true;
      }
      lift = raised;
      raised *= raise;
    }
    return false;
  }

  // The solution [nF + nE + nI] by the last factorisation; rows that join variables are met exactly.
  void solve(const Vector& right, Vector& solution) {
    solve_once(right, solution);
    for (int i = 0; i < refinements; ++i) {
      times(solution, solution.data() + free_, false);
      for (std::size_t k = 0; k < free_; ++k) left_[k] = right[k] - sums_[k];
      for (std::size_t k = 0; k < rows_; ++k)
        left_[free_ + k] = right[free_ + k] - row_sums_[k] - corner_[k] * solution[free_ + k];
      if (std::all_of(left_.begin(), left_.end(), [](double each) { return std::abs(each) <= near; })) return;
      solve_once(left_, correction_);
      for (std::size_t k = 0; k < solution.size(); ++k) solution[k] += correction_[k];
    }
  }

  std::size_t size() const { return ldlt_.size(); }
  std::size_t factor_entries() const { return ldlt_.factor_entries(); }

 private:
  // The solution to the digits that the factors leave.
  void solve_once(const Vector& right, Vector& solution) {
    reduced_ = right;
    if (paths_.offsets(right.data() + free_, offsets_) > rounding) {
      times(offsets_, nullptr, true);
      for (std::size_t i = 0; i < free_; ++i) reduced_[i] -= sums_[i];
      for (std::size_t i = 0; i < rows_; ++i) reduced_[free_ + i] -= row_sums_[i];
    }
    std::fill(joined_.begin(), joined_.end(), 0.0);
    for (std::size_t i = 0; i < free_; ++i) joined_[groups_[i]] += reduced_[i];
    for (std::size_t i = 0; i < in_matrix_.size(); ++i) joined_[unknowns_ + i] = reduced_[free_ + in_matrix_[i]];
    short_rows_.reduce(jacobian_values_, corner_, reduced_.data() + free_, joined_);
    ldlt_.solve(joined_);
    solution.assign(free_ + rows_, 0.0);
    for (std::size_t i = 0; i < free_; ++i) solution[i] = joined_[groups_[i]] + offsets_[i];
    for (std::size_t i = 0; i < in_matrix_.size(); ++i) solution[free_ + in_matrix_[i]] = joined_[unknowns_ + i];
    short_rows_.multipliers(jacobian_values_, corner_, reduced_.data() + free_, joined_, solution.data() + free_);
    times(solution, solution.data() + free_, true);
    for (std::size_t i = 0; i < free_; ++i) sums_[i] = right[i] - sums_[i];
    paths_.multipliers(sums_, solution.data() + free_);
  }

  static constexpr double dual = 1e-8;    // -d: keeps multipliers in place where rows depend on each other
  static constexpr double primal = 1e-6;  // added to H's diagonal, which alone need not have an inverse
  static constexpr double least_lift = 1e-4, raise = 8.0;
  static constexpr int corrections = 12, refinements = 1;
  static constexpr double rounding = 1e-14;  // of right sides
  static constexpr double near = 1e-8;       // of what a solution leaves of them: less than a motion's digits

  // Small, as all entries are read several times a step.
  struct HessianEntry {
    std::uint32_t from, top, left;  // its place among the program's values; two free variables, top <= left
  };
  static std::uint32_t small(std::size_t number) { return static_cast<std::uint32_t>(number); }

  // (H + D_w) * variables + J^T * multipliers [nF] in sums_, J * variables [nE + nI] in row_sums_; of all entries, or
  // for variables on paths only. No multipliers: zeros.
  void times(const Vector& variables, const double* multipliers, bool of_paths) {
    for (std::size_t i = 0; i < free_; ++i) sums_[i] = diagonal_[i] * variables[i];
    std::fill(row_sums_.begin(), row_sums_.end(), 0.0);
    const auto add_hessian = [&](std::size_t k) {
      const HessianEntry& entry = hessian_[k];
      sums_[entry.top] += hessian_values_[k] * variables[entry.left];
      if (entry.top != entry.left) sums_[entry.left] += hessian_values_[k] * variables[entry.top];
    };
    const auto add_jacobian = [&](std::size_t k) {
      const JacobianEntry& entry = jacobian_[k];
      if (multipliers) sums_[entry.column] += jacobian_values_[k] * multipliers[entry.row];
      row_sums_[entry.row] += jacobian_values_[k] * variables[entry.column];
    };
    if (of_paths) {
      for (const std::size_t k : hessian_of_paths_) add_hessian(k);
      for (const std::size_t k : jacobian_of_paths_) add_jacobian(k);
    } else {
      for (std::size_t k = 0; k < hessian_.size(); ++k) add_hessian(k);
      for (std::size_t k = 0; k < jacobian_.size(); ++k) add_jacobian(k);
    }
  }

  // Many a value of the program is 0 whatever the motion, as a force or a velocity that the gait fixes is a factor.
  // Those of two motions without any meaning tell which.
  void find_entries(const Space& space) {
    const std::size_t none = std::numeric_limits<std::size_t>::max();
    Indices variable(space.lower.size(), none), row(space.lower_rows.size(), none);
    for (std::size_t i = 0; i < free_; ++i) variable[space.free[i]] = i;
    for (std::size_t i = 0; i < equal_; ++i) row[space.equal[i]] = i;
    for (std::size_t i = equal_; i < rows_; ++i) row[space.unequal[i - equal_]] = i;
    Vector hessian, jacobian, w = fixed_variables(space), task(program_.parameters()), multipliers(row.size());
    std::mt19937_64 random;
    const auto number = [&random] { return 0.1 + 0.8 * static_cast<double>(random() >> 11) * 0x1p-53; };
    for (int motion = 0; motion < 2; ++motion) {
      if (motion == 1) hessian = program_.hessian(), jacobian = program_.jacobian();
      for (const std::size_t i : space.free) w[i] = number();
      for (double& each : task) each = number();
      for (double& each : multipliers) each = number();
      program_.evaluate_slopes(w, task);
      program_.evaluate_hessian(w, task, multipliers);
    }
    for (std::size_t k = 0; k < hessian.size(); ++k) {
      const auto& [top, left] = program_.hessian_places()[k];
      if (variable[top] == none || variable[left] == none || (hessian[k] == 0 && program_.hessian()[k] == 0)) continue;
      hessian_.push_back({small(k), small(variable[top]), small(variable[left])});
    }
    std::vector<Entry> constant;  // or NaN
    for (std::size_t k = 0; k < jacobian.size(); ++k) {
      const std::size_t at = row[program_.jacobian_places()[k].first];
      const std::size_t column = variable[program_.jacobian_places()[k].second];
      const double value = jacobian[k], other = program_.jacobian()[k];
      if (at == none || column == none || (value == 0 && other == 0)) continue;
      jacobian_.push_back({small(k), small(at), small(column)});
      if (at < equal_) constant.push_back({at, column, value == other ? value : std::nan("")});
    }
    paths_ = Paths(constant, equal_, free_);
  }

  // The places of all entries, in the order in which `factorise` adds them.
  void build() {
    Indices number(rows_, 0);
    for (std::size_t i = 0; i < in_matrix_.size(); ++i) number[in_matrix_[i]] = unknowns_ + i;
    Places places;
    for (const HessianEntry& entry : hessian_) places.emplace_back(groups_[entry.top], groups_[entry.left]);
    for (std::size_t k = 0; k < entries_in_matrix_; ++k)
      places.emplace_back(groups_[jacobian_[k].column], number[jacobian_[k].row]);
    for (const std::size_t group : groups_) places.emplace_back(group, group);
    for (const std::size_t row : in_matrix_) places.emplace_back(number[row], number[row]);
    short_rows_.places(places);
    ldlt_ = Ldlt(unknowns_ + in_matrix_.size(), places);
  }

  Program& program_;
  std::size_t free_, equal_, rows_, unknowns_ = 0;
  std::vector<HessianEntry> hessian_;
  std::vector<JacobianEntry> jacobian_;           // those in the matrix first, then those of short rows
  std::size_t entries_in_matrix_ = 0;
  Indices twice_;                                 // of the Hessian: between two variables that are one unknown
  Indices hessian_of_paths_, jacobian_of_paths_;  // those that meet a variable on a path
  Vector hessian_values_, jacobian_values_;
  Paths paths_;
  Indices groups_;            // the unknown of each variable
  Indices kept_, in_matrix_;  // the rows that join none; those of them that are not short
  ShortRows short_rows_;
  Ldlt ldlt_;
  Vector diagonal_, offsets_, sums_, row_sums_, reduced_, joined_, corner_, left_, correction_;
};

}  // namespace gaitflow
