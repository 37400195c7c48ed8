// Inequality rows that few variables meet, such as those of friction: eliminated before the matrix is factorised.
//
// A row v of J_I with the diagonal entry -d adds v^T v / d to H, and then has no place in the matrix.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "ldlt.hpp"
#include "map_data.hpp"
#include "paths.hpp"

namespace gaitflow {

// An entry of the Jacobian: its place among the program's values, its row, its free variable. Small, as all are read
// several times a step.
struct JacobianEntry {
  std::uint32_t from, row, column;
};

// Which of the rows are short: inequality rows, those from `equal` on, that meet few unknowns, and each of them once.
// Longer ones, such as those of the box in exact motion, take less time in dense columns. unknown: of each free variable.
inline std::vector<bool> find_short_rows(const std::vector<JacobianEntry>& entries, const Indices& unknown,
                                         std::size_t equal, std::size_t rows) {
  constexpr std::size_t most = 10;
  std::vector<Indices> met(rows);
  for (const JacobianEntry& entry : entries) met[entry.row].push_back(unknown[entry.column]);
  std::vector<bool> is_short(rows, false);
  for (std::size_t row = equal; row < rows; ++row) {
    Indices& each = met[row];
    std::sort(each.begin(), each.end());
    const bool once = std::adjacent_find(each.begin(), each.end()) == each.end();
    is_short[row] = once && !each.empty() && each.size() <= most;
  }
  return is_short;
}

// The short rows of one gait, and their part in its matrix and right sides.
class ShortRows {
 public:
  ShortRows() = default;

  // The rows of entries[first .. last), where those of a row are side by side.
  ShortRows(const std::vector<JacobianEntry>& entries, std::size_t first, std::size_t last, const Indices& unknown)
      : first_(first) {
    for (std::size_t k = first; k < last; ++k) {
      if (rows_.empty() || rows_.back().row != entries[k].row) rows_.push_back({entries[k].row, 0});
      ++rows_.back().count;
      unknowns_.push_back(static_cast<std::uint32_t>(unknown[entries[k].column]));
    }
  }

  // Where the matrix has the products of each row's entries, in the order in which `add` adds them.
  void places(std::vector<std::pair<std::size_t, std::size_t>>& places) const {
    const std::uint32_t* unknown = unknowns_.data();
    for (const Row& row : rows_) {
      for (std::size_t i = 0; i < row.count; ++i)
        for (std::size_t j = i; j < row.count; ++j) places.emplace_back(unknown[j], unknown[i]);
      unknown += row.count;
    }
  }

  // Adds them, from the matrix's entry `place` on. values: of all entries; corner: the diagonal entries -d of all rows.
  void add(Ldlt& matrix, std::size_t place, const Vector& values, const Vector& corner) const {
    const double* value = values.data() + first_;
    for (const Row& row : rows_) {
      for (std::size_t i = 0; i < row.count; ++i) {
        const double scaled = value[i] / -corner[row.row];
        for (std::size_t j = i; j < row.count; ++j) matrix.at(place++) += scaled * value[j];
      }
      value += row.count;
    }
  }

  // Adds what the rows' right sides are for the unknowns.
  void reduce(const Vector& values, const Vector& corner, const double* right, Vector& unknowns) const {
    const double* value = values.data() + first_;
    const std::uint32_t* unknown = unknowns_.data();
    for (const Row& row : rows_) {
      const double part = right[row.row] / -corner[row.row];
      for (std::size_t i = 0; i < row.count; ++i) unknowns[unknown[i]] += value[i] * part;
      value += row.count, unknown += row.count;
    }
  }

  // The rows' multipliers, by the unknowns that were solved for.
  void multipliers(const Vector& values, const Vector& corner, const double* right, const Vector& unknowns,
                   double* multipliers) const {
    const double* value = values.data() + first_;
    const std::uint32_t* unknown = unknowns_.data();
    for (const Row& row : rows_) {
      double left = right[row.row];
      for (std::size_t i = 0; i < row.count; ++i) left -= value[i] * unknowns[unknown[i]];
      multipliers[row.row] = left / corner[row.row];
      value += row.count, unknown += row.count;
    }
  }

 private:
  struct Row {
    std::uint32_t row, count;
  };

  std::size_t first_ = 0;
  std::vector<Row> rows_;
  std::vector<std::uint32_t> unknowns_;  // of each entry
};

}  // namespace gaitflow
