// A gait map in C++17, without any library: which gait a task takes, and where to start an optimiser.
//
//   const gaitflow::GaitMap map("map.bin");
//   const gaitflow::Choice choice = map.select(0.9, 0.6);  // m/s, s
//   if (choice.gait) const gaitflow::WarmStart start = map.warm_start(*choice.gait, 0.9, 0.6);
//
// It answers as gaitflow.runtime.GaitMap does. Immutable: any number of threads may ask one map.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "map_file.hpp"

namespace gaitflow {

// gait is a gait of the map, nullptr outside its domain; probabilities has one for each gait, empty outside.
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

class GaitMap {
 public:
  // Throws MapError for a file that is missing, damaged or of another format.
  explicit GaitMap(const std::string& path) : map_(read_map(path)) {}

  const MapFile& file() const { return map_; }
  const std::vector<Gait>& gaits() const { return map_.gaits; }
  const Layout& layout() const { return map_.layout; }

  // Whether the map answers for a task: every grid task around it has a feasible gait.
  bool contains(double speed, double cycle_duration) const {
    check(speed, cycle_duration);
    const Around row = around(map_.speeds, speed), column = around(map_.cycle_durations, cycle_duration);
    if (!row.inside || !column.inside) return false;
    const auto feasible = [this](std::size_t i, std::size_t j) {
      return map_.feasible[i * map_.cycle_durations.size() + j] != 0;
    };
    return feasible(row.low, column.low) && feasible(row.low, column.high) && feasible(row.high, column.low) &&
           feasible(row.high, column.high);
  }

  // One probability a gait, anywhere: outside the domain it is a guess. float32, as in the ONNX graph.
  std::vector<float> probabilities(double speed, double cycle_duration) const {
    check(speed, cycle_duration);
    std::vector<float> values{static_cast<float>(speed), static_cast<float>(cycle_duration)}, next;
    for (const Layer& layer : map_.layers) {
      next = layer.biases;
      const float* weight = layer.weights.data();
      for (const float value : values)
        for (float& sum : next) sum += *weight++ * value;
      if (&layer != &map_.layers.back())
        for (float& value : next) value = std::max(value, 0.0f);
      values.swap(next);
    }
    for (float& value : values) value /= map_.temperature;
    const float most = *std::max_element(values.begin(), values.end());
    float total = 0;
    for (float& value : values) total += value = std::exp(value - most);
    for (float& value : values) value /= total;
    return values;
  }

  // The likeliest gait, of equal ones the first. Throws std::invalid_argument for a number that is not finite.
  Choice select(double speed, double cycle_duration) const {
    if (!contains(speed, cycle_duration)) return {false, nullptr, 0.0, {}};
    std::vector<float> all = probabilities(speed, cycle_duration);
    const std::size_t best = static_cast<std::size_t>(std::max_element(all.begin(), all.end()) - all.begin());
    return {true, &map_.gaits[best], static_cast<double>(all[best]), std::move(all)};
  }

  // Predicted by the atlas; the mean of the gait's region where the atlas does not know the gait.
  WarmStart warm_start(const Gait& gait, double speed, double cycle_duration) const {
    check(speed, cycle_duration);
    const std::size_t number = number_of(gait);
    const Cell cell = cell_of(speed, cycle_duration);
    const Sheet* chosen = nullptr;
    double chosen_cost = 0;
    bool chosen_certain = false;
    for (const Sheet& sheet : map_.sheets) {
      if (sheet.gait != number) continue;
      double share = 0, log_cost = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        const std::int32_t node = sheet.node_at[cell.place[k]];
        if (node < 0) continue;
        share += cell.weight[k];
        log_cost += cell.weight[k] * sheet.log_costs[static_cast<std::size_t>(node)];
      }
      if (share <= 0) continue;
      const double cost = std::exp(log_cost / share);
      const bool certain = share >= support;
      if (!chosen || certain > chosen_certain || (certain == chosen_certain && cost < chosen_cost)) {
        chosen = &sheet;
        chosen_cost = cost;
        chosen_certain = certain;
      }
    }
    return chosen ? predicted(*chosen, cell) : mean_start(gait);
  }

  // The mean over the gait's region of tasks.
  WarmStart mean_start(const Gait& gait) const {
    return {&gait.pattern, &gait.space, gait.primal, gait.multipliers_bounds, gait.multipliers_rows};
  }

 private:
  static constexpr double snap = 1e-9;     // a task this close to a grid value is on it
  static constexpr double support = 0.75;  // share of the nodes around that a cost has to rest on to be believed
  static constexpr double largest_log = 20.0;

  struct Around {
    bool inside;
    std::size_t low, high;
  };

  struct Cell {
    std::size_t place[4];  // corners of a task's cell in Sheet::node_at
    double weight[4];
  };

  static void check(double speed, double cycle_duration) {
    if (!std::isfinite(speed))
      throw std::invalid_argument("speed = " + std::to_string(speed) + ": must be a finite number");
    if (!std::isfinite(cycle_duration))
      throw std::invalid_argument("cycle_duration = " + std::to_string(cycle_duration) + ": must be a finite number");
  }

  // The last grid value at or below, and the first at or above.
  static Around around(const Vector& axis, double value) {
    const auto above = std::upper_bound(axis.begin(), axis.end(), value + snap);
    const auto high = std::lower_bound(axis.begin(), axis.end(), value - snap);
    if (above == axis.begin() || high == axis.end()) return {false, 0, 0};
    return {true, static_cast<std::size_t>(above - axis.begin()) - 1, static_cast<std::size_t>(high - axis.begin())};
  }

  // The lower index of the value's cell, and how far into it; the nearest beyond the ends.
  static std::pair<std::size_t, double> cell_on(const Vector& axis, double value) {
    const auto above = std::upper_bound(axis.begin(), axis.end(), value);
    const std::ptrdiff_t last = static_cast<std::ptrdiff_t>(axis.size()) - 2;
    const auto index = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>((above - axis.begin()) - 1, 0, last));
    return {index, std::clamp((value - axis[index]) / (axis[index + 1] - axis[index]), 0.0, 1.0)};
  }

  Cell cell_of(double speed, double cycle_duration) const {
    const auto [i, s] = cell_on(map_.atlas_speeds, speed);
    const auto [j, t] = cell_on(map_.atlas_cycle_durations, cycle_duration);
    const std::size_t row = map_.atlas_cycle_durations.size(), first = i * row + j;
    return {{first, first + 1, first + row, first + row + 1}, {(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t}};
  }

  std::size_t number_of(const Gait& gait) const {
    for (std::size_t i = 0; i < map_.gaits.size(); ++i)
      if (&map_.gaits[i] == &gait) return i;
    throw std::invalid_argument("gait " + gait.name + ": is none of this map's gaits(); take one of those");
  }

  // Nodes around the task, blended; those that are torn from the nearest one are left out.
  WarmStart predicted(const Sheet& sheet, const Cell& cell) const {
    const std::size_t modes = sheet.mode_count, size = sheet.mean.size();
    const float* near[4] = {nullptr, nullptr, nullptr, nullptr};
    double weight[4] = {0, 0, 0, 0}, log_costs[4] = {0, 0, 0, 0};
    for (std::size_t k = 0; k < 4; ++k) {
      const std::int32_t node = sheet.node_at[cell.place[k]];
      if (node < 0) continue;
      near[k] = sheet.coordinates.data() + static_cast<std::size_t>(node) * modes;
      weight[k] = cell.weight[k];
      log_costs[k] = sheet.log_costs[static_cast<std::size_t>(node)];
    }
    const float* nearest = near[std::max_element(weight, weight + 4) - weight];
    double total = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      double square = 0;
      for (std::size_t mode = 0; near[k] && mode < modes; ++mode) {
        const double apart = static_cast<double>(near[k][mode]) - static_cast<double>(nearest[mode]);
        square += apart * apart;
      }
      if (std::sqrt(square) > sheet.tear) weight[k] = 0;
      total += weight[k];
    }
    Vector point(sheet.mean.begin(), sheet.mean.end());
    double log_cost = 0;
    for (std::size_t k = 0; k < 4; ++k) log_cost += (weight[k] /= total) * log_costs[k];
    for (std::size_t mode = 0; mode < modes; ++mode) {
      double along = 0;
      for (std::size_t k = 0; k < 4; ++k)
        if (weight[k] > 0) along += weight[k] * static_cast<double>(near[k][mode]);
      const float* direction = sheet.modes.data() + mode * size;
      for (std::size_t i = 0; i < size; ++i) point[i] += along * static_cast<double>(direction[i]);
    }
    return joined(sheet, point, std::exp(log_cost));
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
};

}  // namespace gaitflow
