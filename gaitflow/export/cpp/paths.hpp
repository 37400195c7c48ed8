// Variables that move together: feet in stance, and the first and the last knot of a cycle.
//
// A row with nothing but a 1 and a -1 joins two variables: a Newton step is the same for both, but for what the row is
// off. Joined into paths they are one unknown of the KKT matrix.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <vector>

#include "map_data.hpp"

namespace gaitflow {

using Indices = std::vector<std::size_t>;

// An entry of the Jacobian; value is NaN where it changes with w.
struct Entry {
  std::size_t row, variable;
  double value;
};

// Path after path. row is the one that joins a node to the node before, with the sign that it has there; the node
// before has the opposite one. A path's first node has neither.
struct PathNode {
  std::size_t variable, row;
  double sign;  // 1, -1, or 0 of a path's first node
};

class Paths {
 public:
  Paths() = default;

  // The paths in a Jacobian's entries, which come column by column. A row is left out where it would close a ring or
  // make a path branch.
  Paths(const std::vector<Entry>& entries, std::size_t rows, std::size_t variables) {
    std::vector<std::vector<Entry>> by_row(rows);
    for (const Entry& entry : entries) by_row[entry.row].push_back(entry);
    std::vector<std::vector<PathNode>> neighbours(variables);
    Indices end(variables);  // of a path that ends at a variable: its other end
    std::iota(end.begin(), end.end(), std::size_t{0});
    for (const auto& row : by_row) {
      if (row.size() != 2 || row[0].value != -row[1].value || std::abs(row[0].value) != 1) continue;
      const std::size_t one = row[0].variable, other = row[1].variable;
      if (neighbours[one].size() == 2 || neighbours[other].size() == 2 || end[one] == other) continue;
      neighbours[one].push_back({other, row[0].row, row[1].value});
      neighbours[other].push_back({one, row[0].row, row[0].value});
      const std::size_t far = end[one], near = end[other];
      end[far] = near, end[near] = far;
    }
    walk(neighbours);
  }

  const std::vector<PathNode>& nodes() const { return nodes_; }

  // A number for each variable, the same for all of a path: 0, 1, 2, ... in the order of the variables.
  Indices groups(std::size_t variables) const {
    Indices leader(variables), number(variables);
    std::iota(leader.begin(), leader.end(), std::size_t{0});
    std::size_t first = 0;
    for (const PathNode& node : nodes_) {
      if (node.sign == 0) first = node.variable;
      leader[node.variable] = first;
    }
    Indices leaders(leader);
    std::sort(leaders.begin(), leaders.end());
    leaders.erase(std::unique(leaders.begin(), leaders.end()), leaders.end());
    for (std::size_t i = 0; i < variables; ++i)
      number[i] = static_cast<std::size_t>(std::lower_bound(leaders.begin(), leaders.end(), leader[i]) - leaders.begin());
    return number;
  }

  // How much further than the first of its path each variable moves, as the right sides of the rows ask; the largest.
  double offsets(const double* rows, Vector& offsets) const {
    std::fill(offsets.begin(), offsets.end(), 0.0);
    double apart = 0, most = 0;
    for (const PathNode& node : nodes_) {
      apart = node.sign == 0 ? 0.0 : apart + node.sign * rows[node.row];
      offsets[node.variable] = apart;
      most = std::max(most, std::abs(apart));
    }
    return most;
  }

  // Multipliers of the joining rows that balance what is left of the variables' equations.
  void multipliers(const Vector& left, double* rows) const {
    double from_here_on = 0;
    for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
      from_here_on += left[node->variable];
      if (node->sign == 0)
        from_here_on = 0;
      else
        rows[node->row] = node->sign * from_here_on;
    }
  }

 private:
  void walk(const std::vector<std::vector<PathNode>>& neighbours) {
    std::vector<bool> seen(neighbours.size(), false);
    for (std::size_t begin = 0; begin < neighbours.size(); ++begin) {
      if (seen[begin] || neighbours[begin].size() != 1) continue;
      PathNode at{begin, 0, 0.0};
      for (bool further = true; further;) {
        nodes_.push_back(at);
        seen[at.variable] = true;
        further = false;
        for (const PathNode& next : neighbours[at.variable]) {
          if (at.sign != 0 && next.row == at.row) continue;
          at = next;
          further = true;
          break;
        }
      }
    }
  }

  std::vector<PathNode> nodes_;
};

}  // namespace gaitflow
