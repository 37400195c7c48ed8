// How a sparse symmetric matrix is eliminated in dense blocks: fronts, from the leaves of a tree to its root.
//
// Unknowns whose columns of L have nearly the same rows are eliminated together, in one front: a dense matrix of these
// unknowns and the later ones that they meet. What it leaves of the later ones is added into its parent's front.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>
#include <vector>

#include "paths.hpp"

namespace gaitflow {

// Unknowns by their place in the order of elimination: those that a front eliminates are first, ..., first + width - 1.
struct Front {
  std::size_t first, width;
  Indices later;                         // the others that it meets, rising
  std::size_t parent;                    // in the list of fronts, whose size it is at a root
  std::vector<std::uint32_t> in_parent;  // the row of each of `later` in the parent's front; small, as read often

  std::size_t rows() const { return width + later.size(); }
};

struct Elimination {
  Indices order;              // which unknown comes k-th
  std::vector<Front> fronts;  // after their children, in which order a stack holds what they leave
};

namespace detail {

// Some unknowns of an order with the later ones that they meet, while fronts are being joined.
struct Joined {
  Indices columns, later;
  std::size_t parent;
  double zeros = 0;  // entries that are stored and known to be 0
  Indices children;
};

// Whether less time is lost by zeros than is won by one front instead of two.
inline bool worth_joining(const Joined& child, const Joined& parent, double zeros) {
  const double width = static_cast<double>(child.columns.size() + parent.columns.size());
  const double entries = width * ((width + 1) / 2 + static_cast<double>(parent.later.size()));
  return zeros <= (width <= 6 ? 0.6 : width <= 16 ? 0.4 : 0.1) * entries;
}

// Each unknown as a front of its own, in a tree: the later ones that it meets after all before it are eliminated.
inline std::vector<Joined> single_columns(const std::vector<Indices>& neighbours, const Indices& order) {
  const std::size_t size = order.size();
  Indices place(size), merged;
  for (std::size_t k = 0; k < size; ++k) place[order[k]] = k;
  std::vector<Joined> columns(size);
  for (std::size_t k = 0; k < size; ++k) {
    Joined& column = columns[k];
    column.columns = {k};
    for (const std::size_t other : neighbours[order[k]])
      if (place[other] > k) column.later.push_back(place[other]);
    std::sort(column.later.begin(), column.later.end());
    for (const std::size_t child : column.children) {
      merged.clear();
      const Indices& met = columns[child].later;  // k is the first of them
      std::set_union(column.later.begin(), column.later.end(), met.begin() + 1, met.end(), std::back_inserter(merged));
      column.later.swap(merged);
    }
    column.parent = column.later.empty() ? size : column.later.front();
    if (column.parent < size) columns[column.parent].children.push_back(k);
  }
  return columns;
}

// Joins fronts with their parents where that is worth it; a front that was joined to its parent has no columns left.
inline void join(std::vector<Joined>& fronts) {
  for (std::size_t k = 0; k < fronts.size(); ++k) {
    Joined& parent = fronts[k];
    Indices left;
    // Those with the most rows in common first.
    std::sort(parent.children.begin(), parent.children.end(), [&](std::size_t one, std::size_t other) {
      return fronts[one].later.size() > fronts[other].later.size();
    });
    for (const std::size_t number : parent.children) {
      Joined& child = fronts[number];
      const std::size_t more = parent.columns.size() + parent.later.size() - child.later.size();
      const double zeros = parent.zeros + child.zeros + static_cast<double>(child.columns.size() * more);
      if (!worth_joining(child, parent, zeros)) {
        left.push_back(number);
        continue;
      }
      parent.zeros = zeros;
      parent.columns.insert(parent.columns.begin(), child.columns.begin(), child.columns.end());
      left.insert(left.end(), child.children.begin(), child.children.end());
      child.columns.clear();
    }
    parent.children = left;
  }
}

}  // namespace detail

// `order` says which unknown comes k-th; neighbours[i] are the unknowns that i meets in the matrix, without i. The order
// that is kept is another one with the same factors.
inline Elimination eliminate(const std::vector<Indices>& neighbours, const Indices& order) {
  std::vector<detail::Joined> joined = detail::single_columns(neighbours, order);
  detail::join(joined);
  const std::size_t size = order.size();
  Elimination found;
  Indices place(size), front_of(size);
  std::vector<std::pair<std::size_t, bool>> waiting;  // a front, and whether its children are done
  for (std::size_t root = size; root-- > 0;)
    if (joined[root].parent == size && !joined[root].columns.empty()) waiting.emplace_back(root, false);
  while (!waiting.empty()) {
    const auto [number, ready] = waiting.back();
    const detail::Joined& front = joined[number];
    if (!ready) {
      waiting.back().second = true;
      for (const std::size_t child : front.children) waiting.emplace_back(child, false);
      continue;
    }
    waiting.pop_back();
    found.fronts.push_back({found.order.size(), front.columns.size(), front.later, 0, {}});
    for (const std::size_t column : front.columns) {
      place[column] = found.order.size();
      front_of[found.order.size()] = found.fronts.size() - 1;
      found.order.push_back(order[column]);
    }
  }
  for (Front& front : found.fronts) {
    for (std::size_t& each : front.later) each = place[each];
    std::sort(front.later.begin(), front.later.end());
    front.parent = front.later.empty() ? found.fronts.size() : front_of[front.later.front()];
  }
  for (Front& front : found.fronts) {
    if (front.parent == found.fronts.size()) continue;
    const Front& parent = found.fronts[front.parent];
    for (const std::size_t each : front.later) {
      const bool own = each < parent.first + parent.width;
      const auto at = std::lower_bound(parent.later.begin(), parent.later.end(), each) - parent.later.begin();
      front.in_parent.push_back(
          static_cast<std::uint32_t>(own ? each - parent.first : parent.width + static_cast<std::size_t>(at)));
    }
  }
  return found;
}

}  // namespace gaitflow
