// A gait's predicted start refined into a motion by Newton steps on the central path, as gaitflow/runtime/refine.py.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>

#include "atlas.hpp"
#include "gait_map.hpp"
#include "interior_point.hpp"
#include "starts.hpp"

namespace gaitflow {

// One gait refined. cost in the scenario's units; violation is the worst of a row or a bound, in the problem's scaled
// units. refined: converged, and feasible by that.
struct Attempt {
  const Candidate* candidate;
  Ending ending;
  double cost, violation;
  std::size_t iterations;
  Vector primal;  // [nw]

  static constexpr double feasible_within = 1e-6;

  bool feasible() const { return violation <= feasible_within; }
  bool refined() const { return feasible() && ending == Ending::converged; }
};

// How hard a candidate is tried: as a rival, as one that promises much, or as the first of a plan.
enum class Effort : std::size_t { rival = 1, promising = 2, first = 3 };

// A map's gaits, each pattern with a matrix of its own, ordered once. For one thread.
class Refiner {
 public:
  Refiner(const GaitMap& map, const Functions& functions)
      : map_(map), atlas_(map.file().atlas), program_(functions, map.file()) {
    for (const Sheet& sheet : map.file().atlas.sheets) method(sheet.space);
  }

  // Solve for a place from one of its `Starts` after the other. Where none converges the motion is the last one's.
  Attempt fast(const Candidate& candidate, const Vector& place, Effort effort = Effort::first) {
    const Vector task = map_.parameters(place);
    const double scale = map_.file().cost_scale;
    const bool is_rival = effort == Effort::rival, is_wide = place.size() > AtlasView::near_axes;
    const std::size_t iterations = is_rival && !is_wide ? rival_limit : limit;
    std::size_t left = effort == Effort::first ? first_starts : promising_starts;
    if (is_rival) left = is_wide ? 1 : rival_starts;  // the nominal start leads to a motion in the end
    InteriorPoint& method = this->method(space_of(candidate));
    Starts starts(map_, program_, candidate, place, task);
    Attempt attempt{&candidate, Ending::lost, 0, 0, 0, {}};
    for (Start start; left-- > 0 && starts.next(start);) {
      const Outcome outcome = method.follow(task, start.point, start.unit, start.barrier, iterations, start.careful);
      attempt.ending = outcome.ending;
      attempt.cost = outcome.cost * scale;
      attempt.violation = violation(method);
      attempt.iterations += outcome.iterations;
      if (attempt.refined()) break;
    }
    attempt.primal = method.w();
    return attempt;
  }

  // What a candidate may cost at a place at the least, in the scenario's units; infinite when nobody knows.
  double least(const Candidate& candidate, const Vector& place) const {
    if (!candidate.sheet) return std::numeric_limits<double>::infinity();
    return atlas_.least_cost(*candidate.sheet, place) * map_.file().cost_scale;
  }

 private:
  static constexpr std::size_t limit = 60, rival_limit = 30;  // iterations of a start, and of a rival's
  static constexpr std::size_t first_starts = 4, promising_starts = 2, rival_starts = 2;

  const Space& space_of(const Candidate& candidate) const {
    return candidate.sheet ? candidate.sheet->space : map_.gaits()[candidate.gait].space;
  }

  // The method of a space; of the mean of a region, made when it is asked for first.
  InteriorPoint& method(const Space& space) {
    std::unique_ptr<InteriorPoint>& method = methods_[&space];
    if (!method) method = std::make_unique<InteriorPoint>(program_, space);
    return *method;
  }

  // The worst row or bound where the method ended, by the program's last rows; infinite where numbers gave out.
  double violation(const InteriorPoint& method) const {
    const Space& space = method.space();
    double worst = 0;
    const auto see = [&worst](const Vector& values, const Vector& least, const Vector& most) {
      for (std::size_t i = 0; i < values.size(); ++i) {
        const double outside = std::max(least[i] - values[i], values[i] - most[i]);
        if (!(outside <= worst)) worst = std::isnan(outside) ? std::numeric_limits<double>::infinity() : outside;
      }
    };
    see(method.w(), space.lower, space.upper);
    see(program_.rows(), space.lower_rows, space.upper_rows);
    return worst;
  }

  const GaitMap& map_;
  AtlasView atlas_;
  Program program_;
  std::map<const Space*, std::unique_ptr<InteriorPoint>> methods_;
};

}  // namespace gaitflow
