// The factorisation L D L^T of a sparse symmetric matrix without pivoting, as a quasi-definite one has it in any order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "dense.hpp"
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
    find_runs();
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
      std::fill_n(rest, triangle(left), 0.0);
      for (const std::size_t child : children_[number]) add(child, front, factors_.data() + starts_[number], rest);
      if (!eliminate_columns(front, factors_.data() + starts_[number])) return false;
      subtract_products(front, factors_.data() + starts_[number], rest);
      if (built_[number] != kept_[number]) std::copy_n(rest, triangle(left), stack_.data() + kept_[number]);
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
    for (std::size_t number = 0; number < elimination_.fronts.size(); ++number)
      forward(elimination_.fronts[number], factors_.data() + starts_[number], work_.data(), met_.data());
    for (std::size_t k = 0; k < size_; ++k) work_[k] /= pivots_[k];
    for (std::size_t number = elimination_.fronts.size(); number-- > 0;)
      backward(elimination_.fronts[number], factors_.data() + starts_[number], work_.data(), met_.data());
    for (std::size_t k = 0; k < size_; ++k) right[order[k]] = work_[k];
  }

  std::size_t size() const { return size_; }
  std::size_t factor_entries() const { return factors_.size(); }

 private:
  // work -= L * the unknowns that the front eliminates; met: room for what it leaves.
  static void forward(const Front& front, const double* __restrict column, double* __restrict work,
                      double* __restrict met) {
    const std::size_t rows = front.rows(), width = front.width, left = front.later.size();
    const std::size_t* __restrict later = front.later.data();
    double* __restrict own = work + front.first;
    if (width == 1) {
      for (std::size_t i = 0; i < left; ++i) work[later[i]] -= column[1 + i] * own[0];
      return;
    }
    std::fill_n(met, left, 0.0);
    for (std::size_t k = 0; k < width; ++k, column += rows) {
      const double value = own[k];
      for (std::size_t i = k + 1; i < width; ++i) own[i] -= column[i] * value;
      for (std::size_t i = 0; i < left; ++i) met[i] += column[width + i] * value;
    }
    for (std::size_t i = 0; i < left; ++i) work[later[i]] -= met[i];
  }

  // The unknowns that the front eliminates -= L^T * the later ones.
  static void backward(const Front& front, const double* __restrict columns, double* __restrict work,
                       double* __restrict met) {
    const std::size_t rows = front.rows(), width = front.width, left = front.later.size();
    const std::size_t* __restrict later = front.later.data();
    double* __restrict own = work + front.first;
    if (width == 1) {
      double value = own[0];
      for (std::size_t i = 0; i < left; ++i) value -= columns[1 + i] * work[later[i]];
      own[0] = value;
      return;
    }
    for (std::size_t i = 0; i < left; ++i) met[i] = work[later[i]];
    for (std::size_t k = width; k-- > 0;) {
      const double* __restrict column = columns + k * rows;
      own[k] -= dense::product(column + k + 1, own + k + 1, width - k - 1) + dense::product(column + width, met, left);
    }
  }

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
      highest = std::max(highest, top + triangle(left));
      kept_.push_back(children_[number].empty() ? top : kept_[children_[number].front()]);
      top = kept_.back() + triangle(left);
      widest = std::max(widest, front.width), most = std::max(most, left);
    }
    factors_.resize(entries), stack_.resize(highest);
    scaled_.resize(widest * most), met_.resize(most);
  }

  void find_runs() {
    for (const Front& front : elimination_.fronts) {
      const Indices& to = front.in_parent;
      Indices ends(to.size());
      for (std::size_t i = to.size(); i-- > 0;) {
        const bool goes_on = i + 1 < to.size() && to[i + 1] == to[i] + 1;
        ends[i] = goes_on ? ends[i + 1] : i + 1;
      }
      runs_.push_back(std::move(ends));
    }
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
    for (std::size_t j = 0; j < count; from += count - j++) {
      const bool own = to[j] < parent.width;
      double* target = own ? columns + to[j] * rows : rest + column_of(to[j] - parent.width, left) - parent.width;
      for (std::size_t i = j; i < count;) {
        const std::size_t end = runs_[child][i];
        dense::add(target + to[i], from - j + i, end - i);
        i = end;
      }
    }
  }

  // Of a lower triangle kept by columns, without what is above: how many entries of `size` columns there are, and where
  // row i of column j is after i.
  static std::size_t triangle(std::size_t size) { return size * (size + 1) / 2; }
  static std::size_t column_of(std::size_t j, std::size_t size) { return j * size - triangle(j); }

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

  // rest -= L D L^T of the rows of later unknowns, a lower triangle; two columns of it by four columns of L at once, so
  // that what is read is used more than once.
  void subtract_products(const Front& front, const double* columns, double* rest) {
    const std::size_t rows = front.rows(), left = front.later.size(), width = front.width;
    for (std::size_t j = 0; j < left; ++j)
      for (std::size_t k = 0; k < width; ++k)
        scaled_[j * width + k] = columns[k * rows + width + j] * pivots_[front.first + k];
    for (std::size_t j = 0; j < left; j += 2) {
      const double *from = columns + width + j, *factor = scaled_.data() + j * width;
      double* next = rest + (left - j);
      for (std::size_t k = 0; k < width; ++k) rest[0] -= from[k * rows] * factor[k];
      if (j + 1 == left) return;
      std::size_t k = 0;
      for (; k + 4 <= width; k += 4)
        dense::subtract<4>(rest + 1, next, from + 1 + k * rows, rows, factor + k, factor + width + k, left - j - 1);
      const double* last = from + 1 + k * rows;
      if (k + 3 == width) dense::subtract<3>(rest + 1, next, last, rows, factor + k, factor + width + k, left - j - 1);
      if (k + 2 == width) dense::subtract<2>(rest + 1, next, last, rows, factor + k, factor + width + k, left - j - 1);
      if (k + 1 == width) dense::subtract<1>(rest + 1, next, last, rows, factor + k, factor + width + k, left - j - 1);
      rest = next + (left - j - 1);
    }
  }

  std::size_t size_ = 0;
  Elimination elimination_;
  std::vector<Indices> children_;     // of each front
  std::vector<Indices> runs_;         // of each front: where rows end that stay next to each other in its parent
  Indices starts_, built_, kept_;     // of each front: its columns in factors_, what it leaves on the stack
  Indices slots_;                     // where the matrix's entries are added, in factors_
  Vector factors_, stack_, pivots_, work_, scaled_, met_;
};

}  // namespace gaitflow
