// What the atlas predicts at a place, by the rule in gaitflow/runtime/atlas.py: costs of all sheets, and a sheet's point.
//
// A place has a value for each axis, in the map's order. All lengths are in steps of the axes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "condensed.hpp"
#include "map_data.hpp"

namespace gaitflow {

// support: how well nodes, and no places without a motion, surround the place: 1 amid or upon nodes, 0 with none in
// reach; cost is NaN then.
struct SheetCost {
  double cost, support;
};

// A sheet's point [ny] on the central path, and its cost, the problem's.
struct Prediction {
  Vector point;
  double cost = 0;
};

class AtlasView {
 public:
  explicit AtlasView(const Atlas& atlas) : atlas_(atlas), axes_(atlas.steps.size()) {}

  // The problem's cost of one pattern at a place, from all of its nodes within reach.
  SheetCost cost(const Sheet& sheet, const Vector& place) const {
    const Vector asked = in_steps(place);
    double total = 0;
    const std::vector<Near> near = weighed(sheet, asked, total);
    if (!(total > 0)) return {std::nan(""), 0.0};
    double square = 0;
    for (const double along : mean_offset(sheet, near, asked, total)) square += along * along;
    const double log = blended(sheet, agreed(sheet, near, asked), asked);
    const double surrounded = 1 - std::sqrt(square) / atlas_.reach, open = total / (total + without_motion(sheet, asked));
    return {std::exp(std::clamp(log, -largest_log, largest_log)), surrounded * open};
  }

  // The sheets with a node within reach: those whose cost is believed, the cheapest first, then the others by support.
  // Over many axes a cost counts over the probability of its gait, and half of the support will do; of costs that are
  // alike the first comes first.
  std::vector<const Sheet*> by_cost(const Vector& place, const std::vector<float>& probabilities) const {
    const bool is_wide = axes_ > near_axes;
    const double believed = is_wide ? atlas_.support / 2 : atlas_.support;
    struct Ranked {
      double doubted;
      double cost;
      const Sheet* sheet;
    };
    std::vector<Ranked> all;
    for (const Sheet& sheet : atlas_.sheets) {
      const SheetCost found = cost(sheet, place);
      double cost = std::isnan(found.cost) ? std::numeric_limits<double>::infinity() : found.cost;
      if (is_wide) {
        cost /= std::max(static_cast<double>(probabilities[sheet.gait]), least_chance);
        cost = std::nearbyint(std::log(cost) / alike);
      }
      const double doubted = found.support < believed ? 1 - std::floor(100 * found.support) / 100 : 0.0;
      if (found.support > 0) all.push_back({doubted, cost, &sheet});
    }
    std::stable_sort(all.begin(), all.end(), [](const Ranked& one, const Ranked& other) {
      return one.doubted != other.doubted ? one.doubted < other.doubted : one.cost < other.cost;
    });
    std::vector<const Sheet*> sheets;
    for (const Ranked& each : all) sheets.push_back(each.sheet);
    return sheets;
  }

  // The first sheet of each gait, in the order of `by_cost`.
  std::vector<const Sheet*> ranked(const Vector& place, const std::vector<float>& probabilities) const {
    std::vector<const Sheet*> best;
    for (const Sheet* each : by_cost(place, probabilities)) {
      const auto same = [&](const Sheet* sheet) { return sheet->gait == each->gait; };
      if (std::none_of(best.begin(), best.end(), same)) best.push_back(each);
    }
    return best;
  }

  // A pattern's point [ny] on the central path at a place, and its cost; false where no node is within reach. Nodes
  // that belong to another motion than the nearest one are left out.
  bool predict(const Sheet& sheet, const Vector& place, Vector& point, double& cost) const {
    const Vector asked = in_steps(place);
    std::vector<Near> near = within_reach(sheet, asked);
    if (near.empty()) return false;
    double least = std::numeric_limits<double>::infinity(), most = -least;  // logarithms of the costs of alike nodes
    const std::size_t modes = sheet.mode_count;
    const Vector nearest = moved(sheet, near.front().node, offset(sheet, near.front().node, asked));
    for (Near& each : near) {
      const Vector own = moved(sheet, each.node, offset(sheet, each.node, asked));
      double apart = 0;
      for (std::size_t mode = 0; mode < modes; ++mode) apart += (own[mode] - nearest[mode]) * (own[mode] - nearest[mode]);
      if (std::sqrt(apart) > sheet.tear) {
        each.weight = 0;
        continue;
      }
      least = std::min(least, sheet.log_costs[each.node]);
      most = std::max(most, sheet.log_costs[each.node]);
    }
    near = agreed(sheet, near, asked);
    const double total = sum_of_weights(near);
    const double log = not_far_off(blended(sheet, near, asked), least, most);
    const Vector lean = mean_offset(sheet, near, asked, total);
    Vector along(modes, 0.0);
    for (const Near& each : near) {
      Vector halfway = offset(sheet, each.node, asked);
      for (std::size_t axis = 0; axis < axes_; ++axis) halfway[axis] = (halfway[axis] + lean[axis]) / 2;
      const Vector coordinates = moved(sheet, each.node, halfway);
      const double share = each.weight / total;
      for (std::size_t mode = 0; mode < modes; ++mode) along[mode] += share * coordinates[mode];
    }
    point = point_at(sheet, along);
    cost = std::exp(std::clamp(log, -largest_log, largest_log));
    return true;
  }

  // First-order predictions of the `count` nodes nearest to a place, nearest first. Nodes out of reach are taken as they
  // are: so far no tangent leads.
  std::vector<Prediction> nearest(const Sheet& sheet, const Vector& place, std::size_t count) const {
    const Vector asked = in_steps(place);
    std::vector<Prediction> found;
    for (const Near& each : around(sheet, asked, count)) {
      const Vector away = each.distance < atlas_.reach ? offset(sheet, each.node, asked) : Vector(axes_, 0.0);
      const double own = sheet.log_costs[each.node];
      const double log = not_far_off(promise(sheet, each.node, away), own, own);
      found.push_back({point_at(sheet, moved(sheet, each.node, away)), std::exp(std::clamp(log, -largest_log, largest_log))});
    }
    return found;
  }

  static constexpr std::size_t near_axes = 3;  // as in gaitflow/runtime/atlas.py

  // What a sheet may cost at a place at the least; infinite with hardly any support. A prediction is as good as its nodes
  // agree: by `doubt` times the standard deviation of what each promises by its whole tangent, over many axes by less.
  // With less than half of the support of a cost that is believed, it counts twice.
  double least_cost(const Sheet& sheet, const Vector& place) const {
    const SheetCost predicted = cost(sheet, place);
    if (!(predicted.support >= hardly_tried)) return std::numeric_limits<double>::infinity();
    if (predicted.support < atlas_.support / 2) return hardly * predicted.cost;
    const Vector asked = in_steps(place);
    double total = 0, mean = 0, squares = 0;
    const std::vector<Near> near = weighed(sheet, asked, total);
    for (const Near& each : near) mean += each.weight * promise(sheet, each.node, offset(sheet, each.node, asked));
    mean /= total;
    for (const Near& each : near) {
      const double off = promise(sheet, each.node, offset(sheet, each.node, asked)) - mean;
      squares += each.weight * off * off;
    }
    const double doubted = predicted.cost * std::exp(-atlas_.doubt * std::sqrt(squares / total));
    return axes_ > near_axes ? std::max(doubted, predicted.cost / most_below) : doubted;
  }

 private:
  static constexpr double largest_log = 200.0;
  static constexpr double least_chance = 1e-6;  // of a gait
  static constexpr double alike = 1e-4;  // relative
  static constexpr double most_off = 1.0;  // of a start's cost, in logarithms, from its nodes'
  static constexpr double hardly_tried = 0.1, hardly = 2.0, most_below = 1.1;
  // As in gaitflow/runtime/nearby.py.
  static constexpr double steep = 0.3, odd = 0.1;
  static constexpr int rounds = 2;

  struct Near {
    std::size_t node;
    double distance, weight;
  };

  // The logarithm of a start's cost, over many axes not far off its nodes' `least` and `most`: rule 5.
  double not_far_off(double log, double least, double most) const {
    return axes_ > near_axes ? std::clamp(log, least - most_off, most + most_off) : log;
  }

  Vector in_steps(const Vector& place) const {
    Vector asked(place);
    for (std::size_t axis = 0; axis < axes_; ++axis) asked[axis] /= atlas_.steps[axis];
    return asked;
  }

  double weight(double distance) const {
    const double closeness = (atlas_.reach - distance) / (atlas_.reach * std::max(distance, atlas_.nearest));
    return closeness * closeness * closeness;
  }

  Vector offset(const Sheet& sheet, std::size_t node, const Vector& asked) const {
    Vector away(axes_);
    for (std::size_t axis = 0; axis < axes_; ++axis) away[axis] = sheet.places[node * axes_ + axis] - asked[axis];
    return away;
  }

  // The nodes within reach in the order of their first axis, and the sum of their weights.
  std::vector<Near> weighed(const Sheet& sheet, const Vector& asked, double& total) const {
    std::vector<Near> near;
    const auto& order = sheet.by_first_axis;
    const auto first = std::lower_bound(order.begin(), order.end(), asked[0] - atlas_.reach,
                                        [&](std::size_t node, double low) { return sheet.places[node * axes_] < low; });
    total = 0;
    for (auto at = first; at != order.end() && sheet.places[*at * axes_] - asked[0] <= atlas_.reach; ++at) {
      double squared = 0;
      for (std::size_t axis = 0; axis < axes_; ++axis) {
        const double away = sheet.places[*at * axes_ + axis] - asked[axis];
        squared += away * away;
      }
      if (!(squared < atlas_.reach * atlas_.reach)) continue;
      near.push_back({*at, 0.0, weight(std::sqrt(squared))});
      total += near.back().weight;
    }
    return near;
  }

  // The sum of the weights of the places within reach that have no motion.
  double without_motion(const Sheet& sheet, const Vector& asked) const {
    double total = 0;
    for (std::size_t at = 0; at < sheet.infeasible.size(); at += axes_) {
      double squared = 0;
      for (std::size_t axis = 0; axis < axes_; ++axis) {
        const double away = sheet.infeasible[at + axis] - asked[axis];
        squared += away * away;
      }
      if (squared < atlas_.reach * atlas_.reach) total += weight(std::sqrt(squared));
    }
    return total;
  }

  // The nodes with weights by distance, steepness and agreement: rule 2.
  std::vector<Near> agreed(const Sheet& sheet, std::vector<Near> near, const Vector& asked) const {
    Vector steady, promises;
    for (Near& each : near) {
      promises.push_back(promise(sheet, each.node, offset(sheet, each.node, asked)));
      const double change = (sheet.log_costs[each.node] - promises.back()) / steep;
      each.weight /= 1 + change * change;
      steady.push_back(each.weight);
    }
    for (int round = 0; round < rounds; ++round) {
      const double log = blended(sheet, near, asked);
      for (std::size_t i = 0; i < near.size(); ++i) {
        const double off = (promises[i] - log) / odd;
        near[i].weight = steady[i] / (1 + off * off);
      }
    }
    return near;
  }

  // The logarithm of the cost by the nodes' weights: tangents are followed half-way.
  double blended(const Sheet& sheet, const std::vector<Near>& near, const Vector& asked) const {
    const double total = sum_of_weights(near);
    const Vector lean = mean_offset(sheet, near, asked, total);
    double log = 0;
    for (const Near& each : near) {
      double own = sheet.log_costs[each.node];
      for (std::size_t axis = 0; axis < axes_; ++axis) {
        const double away = sheet.places[each.node * axes_ + axis] - asked[axis];
        own -= sheet.slopes[each.node * axes_ + axis] * (away + lean[axis]) / 2;
      }
      log += each.weight * own;
    }
    return log / total;
  }

  static double sum_of_weights(const std::vector<Near>& near) {
    double total = 0;
    for (const Near& each : near) total += each.weight;
    return total;
  }

  // The weighted mean of the offsets: by how much the nodes' centre is off the place.
  Vector mean_offset(const Sheet& sheet, const std::vector<Near>& near, const Vector& asked, double total) const {
    Vector mean(axes_, 0.0);
    for (const Near& each : near)
      for (std::size_t axis = 0; axis < axes_; ++axis)
        mean[axis] += each.weight * (sheet.places[each.node * axes_ + axis] - asked[axis]);
    for (double& along : mean) along /= total;
    return mean;
  }

  // The nodes within reach, the nearest first.
  std::vector<Near> within_reach(const Sheet& sheet, const Vector& asked) const {
    std::vector<Near> near = around(sheet, asked, sheet.nodes, atlas_.reach);
    for (Near& each : near) each.weight = weight(each.distance);
    return near;
  }

  // The `count` nodes nearest to a place, of those nearer than `reach`, the nearest first; without weights.
  std::vector<Near> around(const Sheet& sheet, const Vector& asked, std::size_t count,
                           double reach = std::numeric_limits<double>::infinity()) const {
    std::vector<Near> near;
    for (std::size_t node = 0; node < sheet.nodes; ++node) {
      double distance = 0;
      for (std::size_t axis = 0; axis < axes_; ++axis)
        distance = std::hypot(distance, sheet.places[node * axes_ + axis] - asked[axis]);
      if (distance < reach) near.push_back({node, distance, 0.0});
    }
    std::stable_sort(near.begin(), near.end(),
                     [](const Near& one, const Near& other) { return one.distance < other.distance; });
    near.resize(std::min(near.size(), count), {});
    return near;
  }

  // The logarithm of the cost that a node promises, by its slope, at an offset from it.
  double promise(const Sheet& sheet, std::size_t node, const Vector& away) const {
    double log = sheet.log_costs[node];
    for (std::size_t axis = 0; axis < axes_; ++axis) log -= away[axis] * sheet.slopes[node * axes_ + axis];
    return log;
  }

  // The encoded point [ny] at coordinates along a sheet's modes, whose points may be condensed.
  Vector point_at(const Sheet& sheet, const Vector& coordinates) const {
    Vector point(sheet.mean.begin(), sheet.mean.end());
    for (std::size_t mode = 0; mode < coordinates.size(); ++mode) {
      const float* direction = sheet.modes.data() + mode * point.size();
      for (std::size_t i = 0; i < point.size(); ++i) point[i] += coordinates[mode] * static_cast<double>(direction[i]);
    }
    return point.size() == sheet.space.encoded() ? point : expanded(sheet.space, atlas_.barrier, point);
  }

  // A node's coordinates, moved against an offset along its tangents.
  Vector moved(const Sheet& sheet, std::size_t node, const Vector& away) const {
    const std::size_t modes = sheet.mode_count;
    Vector coordinates(modes);
    for (std::size_t mode = 0; mode < modes; ++mode)
      coordinates[mode] = static_cast<double>(sheet.coordinates[node * modes + mode]);
    for (std::size_t axis = 0; axis < axes_; ++axis) {
      const double* tangent = sheet.tangents.data() + (node * axes_ + axis) * modes;
      for (std::size_t mode = 0; mode < modes; ++mode) coordinates[mode] -= away[axis] * tangent[mode];
    }
    return coordinates;
  }

  const Atlas& atlas_;
  std::size_t axes_;
};

}  // namespace gaitflow
