// The factorisation L D L^T of a sparse symmetric matrix without pivoting, as a quasi-definite one has it in any order.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
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
// unknowns, lower triangles of dense columns, waits on a stack for its parent. There are two stacks: a front's own is not
// that of its children, so that neither has to move.
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
    elimination_ = eliminate(neighbours, least_fill(neighbours));
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
      double* columns = factors_.data() + starts_[number];
      for (const std::size_t child : children_[number]) add_to_columns(child, front, columns);
      if (!eliminate_columns(front, columns)) return false;
      double* rest = left_by(number);
      find_rest(front, columns, rest);
      for (const std::size_t child : children_[number]) add_to_rest(child, front, rest);
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
    const std::size_t stride = dense::padded(front.rows()), width = front.width, left = front.later.size();
    const std::size_t* __restrict later = front.later.data();
    double* __restrict own = work + front.first;
    if (width == 1) {
      for (std::size_t i = 0; i < left; ++i) work[later[i]] -= column[1 + i] * own[0];
      return;
    }
    std::fill_n(met, left, 0.0);
    for (std::size_t k = 0; k < width; ++k, column += stride) {
      const double value = own[k];
      for (std::size_t i = k + 1; i < width; ++i) own[i] -= column[i] * value;
      for (std::size_t i = 0; i < left; ++i) met[i] += column[width + i] * value;
    }
    for (std::size_t i = 0; i < left; ++i) work[later[i]] -= met[i];
  }

  // The unknowns that the front eliminates -= L^T * the later ones.
  static void backward(const Front& front, const double* __restrict columns, double* __restrict work,
                       double* __restrict met) {
    const std::size_t stride = dense::padded(front.rows()), width = front.width, left = front.later.size();
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
      const double* __restrict column = columns + k * stride;
      own[k] -= dense::product(column + k + 1, own + k + 1, width - k - 1) + dense::product(column + width, met, left);
    }
  }

  // Where each front's columns are, and on its stack what it leaves.
  void find_memory() {
    const std::vector<Front>& fronts = elimination_.fronts;
    children_.resize(fronts.size()), stack_of_.assign(fronts.size(), 0);
    std::size_t entries = 0, widest = 0, most = 0;
    for (std::size_t number = 0; number < fronts.size(); ++number) {
      const Front& front = fronts[number];
      if (front.parent < fronts.size()) children_[front.parent].push_back(number);
      starts_.push_back(entries);
      entries += dense::padded(front.rows()) * front.width;
      widest = std::max(widest, front.width), most = std::max(most, front.later.size());
    }
    for (std::size_t number = fronts.size(); number-- > 0;)  // parents before their children
      if (fronts[number].parent < fronts.size()) stack_of_[number] = 1 - stack_of_[fronts[number].parent];
    std::array<std::size_t, 2> top{0, 0}, highest{0, 0};
    for (std::size_t number = 0; number < fronts.size(); ++number) {
      const std::size_t own = stack_of_[number], left = fronts[number].later.size();
      if (!children_[number].empty()) top[1 - own] = rests_[children_[number].front()];
      rests_.push_back(top[own]);
      top[own] += dense::padded(left) * whole_panels(left);
      highest[own] = std::max(highest[own], top[own]);
    }
    // A block or a panel at the end may reach beyond.
    factors_.resize(entries + dense::block), weights_.resize(dense::panel * widest), met_.resize(most);
    for (std::size_t own = 0; own < 2; ++own) stacks_[own].resize(highest[own]);
  }

  static std::size_t whole_panels(std::size_t columns) {
    return (columns + dense::panel - 1) / dense::panel * dense::panel;
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
      const std::size_t own = starts_[front_of[low]] + (low - front.first) * dense::padded(front.rows());
      slots_.push_back(static_cast<std::uint32_t>(own + at));
    }
  }

  // What a front leaves: the rows of column j are a stride of its padded rows after those of j - 1.
  double* left_by(std::size_t number) { return stacks_[stack_of_[number]].data() + rests_[number]; }

  // What a child left of unknowns that its parent eliminates, into that one's columns.
  void add_to_columns(std::size_t child, const Front& parent, double* columns) {
    const auto& to = elimination_.fronts[child].in_parent;
    const std::size_t count = to.size(), stride = dense::padded(parent.rows());
    const double* from = left_by(child);
    for (std::size_t j = 0; j < count && to[j] < parent.width; ++j)
      dense::scatter(columns + to[j] * stride, from + j * dense::padded(count), to.data(), j, count);
  }

  // What a child left of unknowns that its parent leaves, too.
  void add_to_rest(std::size_t child, const Front& parent, double* rest) {
    const auto& to = elimination_.fronts[child].in_parent;
    const std::size_t count = to.size(), stride = dense::padded(parent.later.size());
    const double* from = left_by(child);
    for (std::size_t j = count; j-- > 0 && to[j] >= parent.width;)
      dense::scatter(rest + (to[j] - parent.width) * stride - parent.width, from + j * dense::padded(count), to.data(), j,
                     count);
  }

  // A front's columns of L, and its pivots: a panel of columns at once, first by those before it, then by its own.
  bool eliminate_columns(const Front& front, double* columns) {
    const std::size_t rows = front.rows(), stride = dense::padded(rows);
    for (std::size_t first = 0; first < front.width; first += dense::panel) {
      const std::size_t end = std::min(first + dense::panel, front.width);
      if (first > 0) {
        find_weights(front, columns, first, first);
        switch (end - first) {
          case 1: update_panel<1>(columns, stride, first); break;
          case 2: update_panel<2>(columns, stride, first); break;
          case 3: update_panel<3>(columns, stride, first); break;
          default: update_panel<dense::panel>(columns, stride, first);
        }
      }
      for (std::size_t k = first; k < end; ++k) {
        double* column = columns + k * stride;
        const double pivot = pivots_[front.first + k] = column[k];
        if (pivot == 0) return false;
        for (std::size_t j = k + 1; j < end; ++j) {
          const double factor = column[j] / pivot;
          double* other = columns + j * stride;
          for (std::size_t i = j; i < rows; ++i) other[i] -= column[i] * factor;
        }
        const double inverse = 1 / pivot;
        for (std::size_t i = k + 1; i < rows; ++i) column[i] *= inverse;
      }
    }
    return true;
  }

  // rest = -L D L^T of the rows of later unknowns.
  void find_rest(const Front& front, const double* columns, double* rest) {
    const std::size_t stride = dense::padded(front.rows()), left = front.later.size(), rows = dense::padded(left);
    for (std::size_t j = 0; j < left; j += dense::panel) {
      find_weights(front, columns, front.width + j, front.width);
      for (std::size_t i = j / dense::block * dense::block; i < left; i += dense::block)
        dense::subtract_product<dense::panel, true>(rest + j * rows + i, rows, columns + front.width + i, stride,
                                                    weights_.data(), front.width);
    }
  }

  // Of the rows of a panel in the first `count` columns of L: times their pivots.
  void find_weights(const Front& front, const double* columns, std::size_t row, std::size_t count) {
    const std::size_t stride = dense::padded(front.rows());
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t c = 0; c < dense::panel; ++c)
        weights_[k * dense::panel + c] = columns[k * stride + row + c] * pivots_[front.first + k];
  }

  // `count` columns from `first` on, by those before them.
  template <std::size_t count>
  void update_panel(double* columns, std::size_t stride, std::size_t first) {
    for (std::size_t i = first / dense::block * dense::block; i < stride; i += dense::block)
      dense::subtract_product<count, false>(columns + first * stride + i, stride, columns + i, stride, weights_.data(),
                                            first);
  }

  std::size_t size_ = 0;
  Elimination elimination_;
  std::vector<Indices> children_;        // of each front
  Indices starts_, stack_of_, rests_;    // of each front: its columns in factors_, its stack, there what it leaves
  std::vector<std::uint32_t> slots_;     // where the matrix's entries are added, in factors_; small, as read often
  std::array<Vector, 2> stacks_;
  Vector factors_, pivots_, work_, weights_, met_;
};

}  // namespace gaitflow
