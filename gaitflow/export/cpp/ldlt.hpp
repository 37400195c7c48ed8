// The factorisation L D L^T of a sparse symmetric matrix without pivoting, as a quasi-definite one has it in any order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "fronts.hpp"
#include "map_data.hpp"
#include "ordering.hpp"

namespace gaitflow {

// One sparsity, one order, one symbolic factorisation; however often it is factorised, no memory is taken.
//
// Multifrontal (Duff and Reid, 1983): fronts hold their columns of L as dense columns, and what a front leaves of later
// unknowns waits on a stack for its parent.
class Ldlt {
 public:
  Ldlt() = default;

  // places: (row, column) of entries, in either triangle and as often as one likes; entries of one place are added.
  Ldlt(std::size_t size, const std::vector<std::pair<std::size_t, std::size_t>>& places) : size_(size) {
    std::vector<Indices> neighbours(size);
    for (const auto& [row, column] : places) {
      if (row == column) continue;
      neighbours[row].push_back(column);
      neighbours[column].push_back(row);
    }
    for (Indices& each : neighbours) {
      std::sort(each.begin(), each.end());
      each.erase(std::unique(each.begin(), each.end()), each.end());
    }
    elimination_ = eliminate(neighbours, minimum_degree(neighbours));
    find_memory();
    find_slots(places);
    pivots_.resize(size), work_.assign(size, 0.0);
  }

  // The value at entry k's place, to be added to; `clear` first, and anew for each factorisation.
  void clear() { std::fill(factors_.begin(), factors_.end(), 0.0); }
  double& at(std::size_t entry) { return factors_[slots_[entry]]; }

  // False where a pivot is zero.
  bool factorise() {
    for (std::size_t number = 0; number < elimination_.fronts.size(); ++number) {
      const Front& front = elimination_.fronts[number];
      double* rest = stack_.data() + built_[number];
      const std::size_t left = front.later.size();
      std::fill_n(rest, left * left, 0.0);
      for (const std::size_t child : children_[number]) add(child, front, factors_.data() + starts_[number], rest);
      if (!eliminate_columns(front, factors_.data() + starts_[number])) return false;
      subtract_products(front, factors_.data() + starts_[number], rest);
      if (built_[number] != kept_[number]) std::copy_n(rest, left * left, stack_.data() + kept_[number]);
    }
    return true;
  }

  // How many pivots are below, and above, zero.
  std::pair<std::size_t, std::size_t> signs() const {
    std::pair<std::size_t, std::size_t> count{0, 0};
    for (const double pivot : pivots_) count.first += pivot < 0, count.second += pivot > 0;
    return count;
  }

  // The right side becomes the solution, by the last factorisation.
  void solve(Vector& right) {
    const Indices& order = elimination_.order;
    for (std::size_t k = 0; k < size_; ++k) work_[k] = right[order[k]];
    for (std::size_t number = 0; number < elimination_.fronts.size(); ++number) {
      const Front& front = elimination_.fronts[number];
      const std::size_t rows = front.rows(), left = front.later.size();
      const double* column = factors_.data() + starts_[number];
      std::fill_n(met_.begin(), left, 0.0);
      for (std::size_t k = 0; k < front.width; ++k, column += rows) {
        const double value = work_[front.first + k];
        for (std::size_t i = k + 1; i < front.width; ++i) work_[front.first + i] -= column[i] * value;
        for (std::size_t i = 0; i < left; ++i) met_[i] += column[front.width + i] * value;
      }
      for (std::size_t i = 0; i < left; ++i) work_[front.later[i]] -= met_[i];
    }
    for (std::size_t k = 0; k < size_; ++k) work_[k] /= pivots_[k];
    for (std::size_t number = elimination_.fronts.size(); number-- > 0;) {
      const Front& front = elimination_.fronts[number];
      const std::size_t rows = front.rows(), left = front.later.size();
      for (std::size_t i = 0; i < left; ++i) met_[i] = work_[front.later[i]];
      for (std::size_t k = front.width; k-- > 0;) {
        const double* column = factors_.data() + starts_[number] + k * rows;
        double value = work_[front.first + k];
        for (std::size_t i = k + 1; i < front.width; ++i) value -= column[i] * work_[front.first + i];
        for (std::size_t i = 0; i < left; ++i) value -= column[front.width + i] * met_[i];
        work_[front.first + k] = value;
      }
    }
    for (std::size_t k = 0; k < size_; ++k) right[order[k]] = work_[k];
  }

  std::size_t size() const { return size_; }
  std::size_t factor_entries() const { return factors_.size(); }

 private:
  // Where each front's columns are, and on the stack what it leaves: while it is built, and until its parent takes it.
  void find_memory() {
    const std::vector<Front>& fronts = elimination_.fronts;
    children_.resize(fronts.size());
    std::size_t entries = 0, top = 0, highest = 0, widest = 0, most = 0;
    for (std::size_t number = 0; number < fronts.size(); ++number) {
      const Front& front = fronts[number];
      const std::size_t left = front.later.size();
      if (front.parent < fronts.size()) children_[front.parent].push_back(number);
      starts_.push_back(entries);
      entries += front.rows() * front.width;
      built_.push_back(top);
      highest = std::max(highest, top + left * left);
      kept_.push_back(children_[number].empty() ? top : kept_[children_[number].front()]);
      top = kept_.back() + left * left;
      widest = std::max(widest, front.width), most = std::max(most, left);
    }
    factors_.resize(entries), stack_.resize(highest);
    scaled_.resize(widest * most), met_.resize(most);
  }

  void find_slots(const std::vector<std::pair<std::size_t, std::size_t>>& places) {
    Indices place(size_), front_of(size_);
    for (std::size_t k = 0; k < size_; ++k) place[elimination_.order[k]] = k;
    for (std::size_t number = 0; number < elimination_.fronts.size(); ++number) {
      const Front& front = elimination_.fronts[number];
      std::fill_n(front_of.begin() + static_cast<std::ptrdiff_t>(front.first), front.width, number);
    }
    for (const auto& [row, column] : places) {
      const std::size_t low = std::min(place[row], place[column]), high = std::max(place[row], place[column]);
      const Front& front = elimination_.fronts[front_of[low]];
      const auto later = std::lower_bound(front.later.begin(), front.later.end(), high) - front.later.begin();
      const std::size_t at =
          high < front.first + front.width ? high - front.first : front.width + static_cast<std::size_t>(later);
      slots_.push_back(starts_[front_of[low]] + (low - front.first) * front.rows() + at);
    }
  }

  // What a child left, into its parent's columns and into what that one leaves.
  void add(std::size_t child, const Front& parent, double* columns, double* rest) const {
    const Indices& to = elimination_.fronts[child].in_parent;
    const std::size_t count = to.size(), rows = parent.rows(), left = parent.later.size();
    const double* from = stack_.data() + kept_[child];
    for (std::size_t j = 0; j < count; ++j, from += count) {
      double* target = to[j] < parent.width ? columns + to[j] * rows : rest + (to[j] - parent.width) * left - parent.width;
      for (std::size_t i = j; i < count; ++i) target[to[i]] += from[i];
    }
  }

  // A front's columns of L, and its pivots.
  bool eliminate_columns(const Front& front, double* columns) {
    const std::size_t rows = front.rows();
    for (std::size_t k = 0; k < front.width; ++k) {
      double* column = columns + k * rows;
      const double pivot = pivots_[front.first + k] = column[k];
      if (pivot == 0) return false;
      for (std::size_t j = k + 1; j < front.width; ++j) {
        const double factor = column[j] / pivot;
        double* other = columns + j * rows;
        for (std::size_t i = j; i < rows; ++i) other[i] -= column[i] * factor;
      }
      for (std::size_t i = k + 1; i < rows; ++i) column[i] /= pivot;
    }
    return true;
  }

  // rest [left, left] -= L D L^T of the rows of later unknowns, its lower triangle; by four columns of L at once.
  void subtract_products(const Front& front, const double* columns, double* rest) {
    const std::size_t rows = front.rows(), left = front.later.size(), width = front.width;
    for (std::size_t j = 0; j < left; ++j)
      for (std::size_t k = 0; k < width; ++k)
        scaled_[j * width + k] = columns[k * rows + width + j] * pivots_[front.first + k];
    for (std::size_t j = 0; j < left; ++j) {
      double* target = rest + j * left;
      const double* factor = scaled_.data() + j * width;
      std::size_t k = 0;
      for (; k + 4 <= width; k += 4) {
        const double *a = columns + k * rows + width, *b = a + rows, *c = b + rows, *d = c + rows;
        const double fa = factor[k], fb = factor[k + 1], fc = factor[k + 2], fd = factor[k + 3];
        for (std::size_t i = j; i < left; ++i) target[i] -= a[i] * fa + b[i] * fb + c[i] * fc + d[i] * fd;
      }
      for (; k < width; ++k) {
        const double* a = columns + k * rows + width;
        for (std::size_t i = j; i < left; ++i) target[i] -= a[i] * factor[k];
      }
    }
  }

  std::size_t size_ = 0;
  Elimination elimination_;
  std::vector<Indices> children_;     // of each front
  Indices starts_, built_, kept_;     // of each front: its columns in factors_, what it leaves on the stack
  Indices slots_;                     // where the matrix's entries are added, in factors_
  Vector factors_, stack_, pivots_, work_, scaled_, met_;
};

}  // namespace gaitflow
