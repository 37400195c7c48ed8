// A gait map in C++17, without any library: which gait a task takes, and where to start an optimiser.
//
//   const gaitflow::GaitMap map("map.bin");
//   const gaitflow::Vector place = map.place({{"speed", 0.9}, {"cycle_duration", 0.6}});
//   const gaitflow::Choice choice = map.select(place);
//   if (choice.gait) const gaitflow::WarmStart start = map.warm_start(*choice.gait, place);
//
// It answers as gaitflow.runtime.GaitMap does. A place has a value for each of the map's axes, in the order of `axes()`
// and in SI units, slopes in degrees. Immutable: any number of threads may ask one map.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "atlas.hpp"
#include "map_file.hpp"

namespace gaitflow {

// gait is a gait of the map, nullptr outside its domain; probability is the classifier's for it, probabilities has one
// for each gait, empty outside.
struct Choice {
  bool in_domain;
  const Gait* gait;
  double probability;
  std::vector<float> probabilities;
};

// primal [nw], multipliers of bounds [nw] and rows [ng], as the exported problem takes them (CasADi's signs: those of
// cost + multipliers_rows * rows + multipliers_bounds * w). pattern and space belong to the map and live as long.
struct WarmStart {
  const std::string* pattern;
  const Space* space;
  Vector primal, multipliers_bounds, multipliers_rows;
};

// Gait number `gait` of the map by a sheet of its atlas, or, with nullptr, from the mean of its region.
struct Candidate {
  std::size_t gait;
  const Sheet* sheet;
};

class GaitMap {
 public:
  // Throws MapError for a file that is missing, damaged or of another format.
  explicit GaitMap(const std::string& path) : map_(read_map(path)) {
    for (const std::size_t parameter : map_.task.ranged) axes_.push_back(map_.task.names[parameter]);
  }

  const MapFile& file() const { return map_; }
  const std::vector<Gait>& gaits() const { return map_.gaits; }
  const Layout& layout() const { return map_.layout; }

  // The axes that the map ranges over, such as speed and cycle_duration.
  const std::vector<std::string>& axes() const { return axes_; }

  // The place of a task from values by axis. Throws std::invalid_argument for an axis that is unknown, that is missing,
  // given twice, or held at another value.
  Vector place(const std::vector<std::pair<std::string, double>>& values) const {
    Vector place(axes_.size());
    std::vector<bool> given(map_.task.names.size(), false);
    for (const auto& [axis, value] : values) {
      const auto name = std::find(map_.task.names.begin(), map_.task.names.end(), axis);
      const std::size_t parameter = static_cast<std::size_t>(name - map_.task.names.begin());
      if (name == map_.task.names.end()) throw std::invalid_argument("axis " + axis + ": is unknown; " + ask_for());
      if (given[parameter]) throw std::invalid_argument("axis " + axis + ": is given twice");
      given[parameter] = true;
      const auto own = std::find(axes_.begin(), axes_.end(), axis);
      if (own != axes_.end())
        place[static_cast<std::size_t>(own - axes_.begin())] = value;
      else if (value != map_.task.held[parameter])
        throw std::invalid_argument("axis " + axis + ": the map holds it at " +
                                    std::to_string(map_.task.held[parameter]) + "; " + ask_for());
    }
    for (const std::size_t parameter : map_.task.ranged)
      if (!given[parameter])
        throw std::invalid_argument("axis " + map_.task.names[parameter] + ": is missing; " + ask_for());
    check(place);
    return place;
  }

  // What the exported functions take as the task of a place: all its parameters, those held by the map included.
  Vector parameters(const Vector& place) const {
    check(place);
    Vector task = map_.task.held;
    for (std::size_t axis = 0; axis < axes_.size(); ++axis) task[map_.task.ranged[axis]] = place[axis];
    return task;
  }

  // T [s] of a place.
  double cycle_duration(const Vector& place) const {
    const auto& names = map_.task.names;
    const auto at = std::find(names.begin(), names.end(), "cycle_duration") - names.begin();
    return parameters(place).at(static_cast<std::size_t>(at));
  }

  // Whether the map answers for a place: every grid task around it has a feasible gait.
  bool contains(const Vector& place) const {
    check(place);
    std::vector<std::size_t> corners{0};  // places in `feasible` of the grid tasks around
    for (std::size_t axis = 0; axis < axes_.size(); ++axis) {
      const Vector& values = map_.domain.axes[axis];
      const auto above = std::upper_bound(values.begin(), values.end(), place[axis] + snap);
      const auto high = std::lower_bound(values.begin(), values.end(), place[axis] - snap);
      if (above == values.begin() || high == values.end()) return false;
      const auto last = static_cast<std::size_t>(above - values.begin()) - 1;
      const auto first = static_cast<std::size_t>(high - values.begin());
      std::vector<std::size_t> next;
      for (const std::size_t corner : corners) {
        next.push_back(corner * values.size() + first);
        if (last != first) next.push_back(corner * values.size() + last);
      }
      corners.swap(next);
    }
    return std::all_of(corners.begin(), corners.end(), [this](std::size_t i) { return map_.domain.feasible[i] != 0; });
  }

  // One probability a gait by the classifier, anywhere: outside the domain it is a guess. float32, as in the ONNX graph.
  std::vector<float> probabilities(const Vector& place) const {
    check(place);
    std::vector<float> values;
    for (const double value : place) values.push_back(static_cast<float>(std::clamp(value, -farthest, farthest)));
    return map_.classifier.probabilities(std::move(values));
  }

  // The gait that the atlas predicts to cost least, over more than three axes over its probability; where it knows none,
  // the classifier's likeliest, of equal ones the first. Throws std::invalid_argument for a number that is not finite.
  Choice select(const Vector& place) const {
    if (!contains(place)) return {false, nullptr, 0.0, {}};
    std::vector<float> all = probabilities(place);
    const std::size_t best = candidates(place, all).front().gait;
    return {true, &map_.gaits[best], static_cast<double>(all[best]), std::move(all)};
  }

  // Every gait, by each of its patterns that the atlas knows here, in the order of choosing and trying: what the atlas
  // knows, what it believes first; then the other gaits by probability.
  std::vector<Candidate> candidates(const Vector& place, const std::vector<float>& probabilities) const {
    std::vector<Candidate> every;
    std::vector<bool> known(map_.gaits.size(), false);
    for (const Sheet* sheet : AtlasView(map_.atlas).by_cost(place, probabilities)) {
      every.push_back({sheet->gait, sheet});
      known[sheet->gait] = true;
    }
    const auto others = static_cast<std::ptrdiff_t>(every.size());
    for (std::size_t gait = 0; gait < known.size(); ++gait)
      if (!known[gait]) every.push_back({gait, nullptr});
    std::stable_sort(every.begin() + others, every.end(), [&](const Candidate& one, const Candidate& other) {
      return probabilities[one.gait] > probabilities[other.gait];
    });
    return every;
  }

  // Predicted by the atlas; the mean of the gait's region where the atlas does not know the gait.
  WarmStart warm_start(const Gait& gait, const Vector& place) const {
    check(place);
    const std::size_t number = number_of(gait);
    const AtlasView atlas(map_.atlas);
    const bool is_wide = axes_.size() > AtlasView::near_axes;  // over few axes no probability counts
    for (const Sheet* sheet : atlas.ranked(place, is_wide ? probabilities(place) : std::vector<float>())) {
      if (sheet->gait != number) continue;
      Vector point;
      double cost = 0;
      if (atlas.predict(*sheet, place, point, cost)) return joined(*sheet, point, cost);
    }
    return mean_start(gait);
  }

  // The mean over the gait's region of tasks.
  WarmStart mean_start(const Gait& gait) const {
    return {&gait.pattern, &gait.space, gait.primal, gait.multipliers_bounds, gait.multipliers_rows};
  }

 private:
  static constexpr double snap = 1e-9;  // a task this close to a grid value is on it
  static constexpr double largest_log = 20.0;
  static constexpr double farthest = 1e6;  // of what the classifier's float32 is asked for

  void check(const Vector& place) const {
    if (place.size() != axes_.size())
      throw std::invalid_argument("a place has " + std::to_string(place.size()) + " values; " + ask_for());
    for (std::size_t axis = 0; axis < axes_.size(); ++axis)
      if (!std::isfinite(place[axis]))
        throw std::invalid_argument(axes_[axis] + " = " + std::to_string(place[axis]) + ": must be a finite number");
  }

  std::string ask_for() const {
    std::string text = "the map's axes are ";
    for (const std::string& axis : axes_) text += (&axis == &axes_.front() ? "" : ", ") + axis;
    return text;
  }

  std::size_t number_of(const Gait& gait) const {
    for (std::size_t i = 0; i < map_.gaits.size(); ++i)
      if (&map_.gaits[i] == &gait) return i;
    throw std::invalid_argument("gait " + gait.name + ": is none of this map's gaits(); take one of those");
  }

  // The vectors of a point [ny]: free variables, multipliers of rows over the cost, logarithms of those of bounds.
  static WarmStart joined(const Sheet& sheet, const Vector& point, double cost) {
    const Space& space = sheet.space;
    const std::size_t free = space.free.size(), equal = space.equal.size();
    WarmStart start{&sheet.pattern, &space, Vector(space.lower.size()), Vector(space.lower.size(), 0.0),
                    Vector(space.lower_rows.size(), 0.0)};
    for (std::size_t i = 0; i < space.lower.size(); ++i)
      start.primal[i] = space.upper[i] > space.lower[i] ? 0.0 : space.lower[i];
    const double* number = point.data();
    for (const std::size_t i : space.free) start.primal[i] = *number++;
    for (std::size_t i = 0; i < equal; ++i) start.multipliers_rows[space.equal[i]] = *number++ * cost;
    for (const std::size_t i : space.unequal) start.multipliers_rows[i] = *number++ * cost;
    Vector push(free, 0.0);
    // Those of inequality rows follow from the rows' own.
    for (const std::size_t place : space.below) {
      const double value = std::exp(std::min(*number++, largest_log));
      if (place < free) push[place] -= value;
    }
    for (const std::size_t place : space.above) {
      const double value = std::exp(std::min(*number++, largest_log));
      if (place < free) push[place] += value;
    }
    for (std::size_t i = 0; i < free; ++i) start.multipliers_bounds[space.free[i]] = push[i] * cost;
    return start;
  }

  MapFile map_;
  std::vector<std::string> axes_;
};

}  // namespace gaitflow
