// The factorisation L D L^T of a sparse symmetric matrix without pivoting, as a quasi-definite one has it in any order.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "map_data.hpp"
#include "ordering.hpp"

namespace gaitflow {

// One sparsity, one order, one symbolic factorisation; however often it is factorised, no memory is taken.
class Ldlt {
 public:
  Ldlt() = default;

  // places: (row, column) of entries, in either triangle and as often as one likes; entries of one place are added.
  Ldlt(std::size_t size, const std::vector<std::pair<std::size_t, std::size_t>>& places) : size_(size) {
    std::vector<std::vector<std::size_t>> neighbours(size);
    for (const auto& [row, column] : places) {
      if (row == column) continue;
      neighbours[row].push_back(column);
      neighbours[column].push_back(row);
    }
    for (auto& each : neighbours) {
      std::sort(each.begin(), each.end());
      each.erase(std::unique(each.begin(), each.end()), each.end());
    }
    order_ = minimum_degree(neighbours);
    std::vector<std::size_t> place(size);  // in the order of elimination
    for (std::size_t k = 0; k < size; ++k) place[order_[k]] = k;
    find_matrix(neighbours, place);
    find_factors();
    for (const auto& [row, column] : places) {
      const std::size_t low = std::min(place[row], place[column]), high = std::max(place[row], place[column]);
      const auto begin = row_of_.begin() + static_cast<std::ptrdiff_t>(starts_[high]);
      const auto end = row_of_.begin() + static_cast<std::ptrdiff_t>(starts_[high + 1]);
      slots_.push_back(static_cast<std::size_t>(std::lower_bound(begin, end, low) - row_of_.begin()));
    }
    values_.resize(row_of_.size());
    pivots_.resize(size), inverse_.resize(size), work_.assign(size, 0.0), used_.resize(size);
  }

  // The value at entry k's place, to be added to; `clear` first.
  void clear() { std::fill(values_.begin(), values_.end(), 0.0); }
  double& at(std::size_t entry) { return values_[slots_[entry]]; }

  // Row by row of L. False where a pivot is zero.
  bool factorise() {
    std::copy(factor_starts_.begin(), factor_starts_.end() - 1, used_.begin());
    for (std::size_t k = 0; k < size_; ++k) {
      for (std::size_t i = starts_[k]; i < starts_[k + 1]; ++i) work_[row_of_[i]] = values_[i];
      double pivot = work_[k];
      work_[k] = 0;
      for (std::size_t i = reach_starts_[k]; i < reach_starts_[k + 1]; ++i) {
        const std::size_t column = reach_[i], end = used_[column]++;
        const double value = work_[column];
        work_[column] = 0;
        for (std::size_t j = factor_starts_[column]; j < end; ++j) work_[factor_rows_[j]] -= factors_[j] * value;
        const double factor = value * inverse_[column];
        pivot -= value * factor;
        factors_[end] = factor;
      }
      if (pivot == 0) {
        return false;
      }
      pivots_[k] = pivot;
      inverse_[k] = 1 / pivot;
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
    for (std::size_t k = 0; k < size_; ++k) work_[k] = right[order_[k]];
    for (std::size_t k = 0; k < size_; ++k)
      for (std::size_t j = factor_starts_[k]; j < factor_starts_[k + 1]; ++j)
        work_[factor_rows_[j]] -= factors_[j] * work_[k];
    for (std::size_t k = size_; k-- > 0;) {
      double value = work_[k] * inverse_[k];
      for (std::size_t j = factor_starts_[k]; j < factor_starts_[k + 1]; ++j)
        value -= factors_[j] * work_[factor_rows_[j]];
      work_[k] = value;
    }
    for (std::size_t k = 0; k < size_; ++k) right[order_[k]] = work_[k], work_[k] = 0;
  }

  std::size_t size() const { return size_; }
  std::size_t factor_entries() const { return factors_.size(); }

 private:
  // The matrix's upper triangle in the order of elimination, column by column, each with its diagonal.
  void find_matrix(const std::vector<std::vector<std::size_t>>& neighbours, const std::vector<std::size_t>& place) {
    starts_.push_back(0);
    for (std::size_t k = 0; k < size_; ++k) {
      for (const std::size_t other : neighbours[order_[k]])
        if (place[other] < k) row_of_.push_back(place[other]);
      row_of_.push_back(k);
      std::sort(row_of_.begin() + static_cast<std::ptrdiff_t>(starts_.back()), row_of_.end());
      starts_.push_back(row_of_.size());
    }
  }

  // Where L has entries: row k in the columns on the paths from its entries up the elimination tree to k.
  void find_factors() {
    std::vector<std::size_t> parent(size_, size_), seen(size_, size_), count(size_, 0);
    reach_starts_.push_back(0);
    for (std::size_t k = 0; k < size_; ++k) {
      seen[k] = k;
      for (std::size_t i = starts_[k]; i < starts_[k + 1]; ++i)
        for (std::size_t at = row_of_[i]; seen[at] != k; at = parent[at]) {
          if (parent[at] == size_) parent[at] = k;
          seen[at] = k;
          ++count[at];
          reach_.push_back(at);
        }
      std::sort(reach_.begin() + static_cast<std::ptrdiff_t>(reach_starts_.back()), reach_.end());
      reach_starts_.push_back(reach_.size());
    }
    factor_starts_.push_back(0);
    for (const std::size_t each : count) factor_starts_.push_back(factor_starts_.back() + each);
    factor_rows_.resize(reach_.size());
    factors_.resize(reach_.size());
    std::vector<std::size_t> used(factor_starts_.begin(), factor_starts_.end() - 1);
    for (std::size_t k = 0; k < size_; ++k)
      for (std::size_t i = reach_starts_[k]; i < reach_starts_[k + 1]; ++i) factor_rows_[used[reach_[i]]++] = k;
  }

  std::size_t size_ = 0;
  std::vector<std::size_t> order_;                              // which unknown comes k-th
  std::vector<std::size_t> starts_, row_of_, slots_;            // the matrix, and where its entries are added
  std::vector<std::size_t> reach_starts_, reach_;               // columns of L with an entry in row k, rising
  std::vector<std::size_t> factor_starts_, factor_rows_, used_; // rows of L's entries, column by column
  Vector values_, factors_, pivots_, inverse_, work_;
};

}  // namespace gaitflow
