// In which order the unknowns of a symmetric matrix are eliminated, so that its factors stay sparse.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

namespace gaitflow {

// Always the unknown next whose elimination joins the fewest pairs of its neighbours, as far as is known cheaply: those
// that the last elimination beside it has joined are left out (approximate minimum fill; Rothberg and Eisenstat, 1998).
// Of equal ones that with the fewest neighbours, then the first. neighbours[i]: rising, without i. Some milliseconds for
// a gait's matrix in the plane, a tenth of a second in space.
inline std::vector<std::size_t> least_fill(std::vector<std::vector<std::size_t>> neighbours) {
  std::vector<std::size_t> joined(neighbours.size(), 0);  // how many neighbours the last elimination has joined
  const auto pairs = [](std::size_t count) { return count * (count - 1) / 2; };
  const auto score = [&](std::size_t i) {
    const std::size_t degree = neighbours[i].size(), known = std::min(joined[i], degree);
    return std::make_tuple(pairs(degree) - pairs(known), degree, i);
  };
  std::set<std::tuple<std::size_t, std::size_t, std::size_t>> waiting;
  for (std::size_t i = 0; i < neighbours.size(); ++i) waiting.insert(score(i));
  std::vector<std::size_t> order, all;
  while (!waiting.empty()) {
    const std::size_t next = std::get<2>(*waiting.begin());
    waiting.erase(waiting.begin());
    order.push_back(next);
    const std::vector<std::size_t> left = std::move(neighbours[next]);
    for (const std::size_t each : left) {
      std::vector<std::size_t>& own = neighbours[each];
      waiting.erase(score(each));
      all.clear();
      std::set_union(own.begin(), own.end(), left.begin(), left.end(), std::back_inserter(all));
      all.erase(std::remove_if(all.begin(), all.end(), [&](std::size_t i) { return i == each || i == next; }), all.end());
      own.assign(all.begin(), all.end());
      joined[each] = left.size() - 1;
      waiting.insert(score(each));
    }
  }
  return order;
}

}  // namespace gaitflow
