// A classifier of known tasks: the nearest of them vote for their gaits.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "cursor.hpp"

namespace gaitflow {

struct Neighbours {
  std::vector<float> scale;  // of the axes, divides
  std::size_t nearest, count;
  std::vector<float> known;         // [tasks, axes], scaled
  std::vector<std::uint32_t> gait;  // [tasks]

  std::size_t gaits() const { return count; }

  // The gaits' shares among the nearest, of values of the axes. Of tasks equally far the first ones are taken.
  std::vector<float> operator()(std::vector<float> values) const {
    for (std::size_t i = 0; i < values.size(); ++i) values[i] /= scale[i];
    std::vector<std::pair<float, std::uint32_t>> found;  // distance and gait, the nearest first
    const float* number = known.data();
    for (const std::uint32_t each : gait) {
      float distance = 0;
      for (const float value : values) {
        const float difference = value - *number++;
        distance += difference * difference;
      }
      if (found.size() == nearest) {
        if (!(distance < found.back().first)) continue;
        found.pop_back();
      }
      std::size_t place = found.size();
      while (place > 0 && distance < found[place - 1].first) --place;
      found.insert(found.begin() + static_cast<std::ptrdiff_t>(place), {distance, each});
    }
    std::vector<float> votes(count, 0.0f);
    for (const auto& [distance, each] : found) votes[each] += 1.0f;
    for (float& vote : votes) vote /= static_cast<float>(nearest);
    return votes;
  }
};

namespace detail {

inline Neighbours read_neighbours(Cursor& file, std::size_t axes) {
  Neighbours all;
  all.scale = file.finite<float>(axes);
  for (const float each : all.scale) file.require(each > 0, "an axis of the known tasks has no positive scale");
  all.nearest = file.count(1, 100000, "no known tasks vote, or too many");
  const std::size_t tasks = file.count(all.nearest, 100000000, "there are fewer known tasks than vote, or too many");
  all.count = file.count(1, 4096, "there are no gaits, or too many");
  all.known = file.finite<float>(tasks * axes);
  all.gait = file.places(tasks, all.count, "a known task has a gait that the map has not");
  return all;
}

}  // namespace detail

}  // namespace gaitflow
