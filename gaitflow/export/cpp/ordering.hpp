// In which order the unknowns of a symmetric matrix are eliminated, so that its factors stay sparse.
#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

namespace gaitflow {

// Always the unknown with the fewest neighbours next, of equal ones the first; its neighbours become each other's.
// neighbours[i]: rising, without i. Some milliseconds for a gait's matrix in the plane, a tenth of a second in space.
inline std::vector<std::size_t> minimum_degree(std::vector<std::vector<std::size_t>> neighbours) {
  std::set<std::pair<std::size_t, std::size_t>> waiting;
  for (std::size_t i = 0; i < neighbours.size(); ++i) waiting.emplace(neighbours[i].size(), i);
  std::vector<std::size_t> order, joined;
  while (!waiting.empty()) {
    const std::size_t next = waiting.begin()->second;
    waiting.erase(waiting.begin());
    order.push_back(next);
    const std::vector<std::size_t> left = std::move(neighbours[next]);
    for (const std::size_t each : left) {
      std::vector<std::size_t>& own = neighbours[each];
      waiting.erase({own.size(), each});
      joined.clear();
      std::set_union(own.begin(), own.end(), left.begin(), left.end(), std::back_inserter(joined));
      joined.erase(std::remove_if(joined.begin(), joined.end(), [&](std::size_t i) { return i == each || i == next; }),
                   joined.end());
      own.assign(joined.begin(), joined.end());
      waiting.emplace(own.size(), each);
    }
  }
  return order;
}

}  // namespace gaitflow
