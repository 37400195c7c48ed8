// A motion for a task: the gait that is predicted to cost least, refined; the next one when that fails.
//
//   const gaitflow::GaitMap map("map.bin");
//   gaitflow::Planner planner(map, GAITFLOW_FUNCTIONS);   // after #include "map.h"; one a thread
//   const gaitflow::Plan plan = planner.plan(map.place({{"speed", 0.9}, {"cycle_duration", 0.6}}));
//   if (plan.refined) plan.motion.feet ...
//
// It answers as GaitMap.plan does in Python, but for IPOPT, the fallback there: what does not converge here says so.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "gait_map.hpp"
#include "refine.hpp"
#include "trajectory.hpp"

namespace gaitflow {

// A gait that was tried, and how that ended.
struct Tried {
  const Gait* gait;
  Ending ending;
  double violation;
  std::size_t iterations;
};

// gait and pattern point into the map; nullptr outside its domain, where nothing is tried. refined: converged, and no
// row or bound of the problem is off by more than 1e-6; otherwise the motion is the least infeasible one. cost in the
// scenario's units. path: "fast" for the first gait, "next:<n>" for the n-th after it, "cheaper:<n>" when that one was
// refined, too, and costs less than the first, "failed" when none refined. iterations over all tried.
struct Plan {
  bool in_domain = false, refined = false;
  const Gait* gait = nullptr;
  const std::string* pattern = nullptr;
  double probability = 0, cost = 0, violation = 0;
  std::size_t iterations = 0;
  std::string path = "failed";
  std::vector<Tried> tried;
  Vector primal;      // [nw]
  Trajectory motion;  // SI units
};

// For one thread; planners of one map share it. Making one takes memory and, in space, a tenth of a second a gait; a
// plan takes none but for its own and its starts'.
class Planner {
 public:
  // Throws std::runtime_error where the functions are not those of the map, which has to live as long.
  Planner(const GaitMap& map, const Functions& functions) : map_(map), refiner_(map, functions) {}

  // A plan for a place, from the `top` gaits that may cost least, or from the `only` one, which is one of the map's.
  // Throws std::invalid_argument for a number that is not finite.
  Plan plan(const Vector& place, std::size_t top = 5, const Gait* only = nullptr) {
    Plan plan;
    plan.in_domain = map_.contains(place);
    if (!plan.in_domain) return plan;
    const std::vector<float> probabilities = map_.probabilities(place);
    std::vector<Candidate> candidates = map_.candidates(place, probabilities);
    if (only) {
      const auto other = [&](const Candidate& each) { return &map_.gaits()[each.gait] != only; };
      candidates.erase(std::remove_if(candidates.begin(), candidates.end(), other), candidates.end());
    }
    if (candidates.empty()) throw std::invalid_argument("the gait is none of this map's gaits(); take one of those");
    Indices gaits;  // in the order of their first candidates
    for (const Candidate& each : candidates)
      if (number(gaits, each.gait) == gaits.size()) gaits.push_back(each.gait);
    const std::vector<const Candidate*> sure = firsts_of_likely(candidates, gaits, probabilities, place.size());
    const std::size_t most = std::max<std::size_t>(top, 1);
    const std::vector<Attempt> attempts = this->attempts(candidates, gaits, sure, probabilities, most, place);
    const Attempt& solved = *std::min_element(attempts.begin(), attempts.end(), earlier);
    const Attempt& least = *std::min_element(attempts.begin(), attempts.end(), cheaper);
    // Of gaits that tie, the one that `select` names.
    const Attempt& best = least.refined() && least.cost > solved.cost * (1 - least_saving) ? solved : least;
    const Candidate& taken = *best.candidate;
    plan.refined = best.refined();
    plan.gait = &map_.gaits()[taken.gait];
    plan.pattern = taken.sheet ? &taken.sheet->pattern : &plan.gait->pattern;
    plan.probability = static_cast<double>(probabilities[taken.gait]);
    plan.cost = best.cost;
    plan.violation = best.violation;
    for (const Attempt& each : attempts) {
      plan.iterations += each.iterations;
      plan.tried.push_back({&map_.gaits()[each.candidate->gait], each.ending, each.violation, each.iterations});
    }
    if (plan.refined) plan.path = path(number(gaits, taken.gait), number(gaits, solved.candidate->gait));
    plan.primal = best.primal;
    plan.motion = unpack(map_.layout(), plan.primal, map_.cycle_duration(place));
    return plan;
  }

 private:
  // Relative cost that another one must promise to save, and for which it is tried harder.
  static constexpr double least_saving = 1e-3, great_saving = 0.5;
  // Over few axes, where the first motion costs over `surprise` times what it might have at the least: the share of the
  // least cost so far below which another one has to be for being tried.
  static constexpr double surprise = 4.0, surprised = 1.25;
  // The probability from which on a gait is tried whatever it may cost: over few axes, over more, and over many.
  static constexpr double likely_few = 0.5, likely = 0.2, likely_wide = 0.02;
  // From which on such a gait is tried as hard as the first one.
  static constexpr double even = 0.5;
  // Below which, over more than a few axes, it is tried only if it is first.
  static constexpr double unlikely = 3e-4;
  static constexpr std::size_t few_axes = 2;

  // The first candidate that the atlas knows of each likely gait.
  static std::vector<const Candidate*> firsts_of_likely(const std::vector<Candidate>& candidates, const Indices& gaits,
                                                        const std::vector<float>& probabilities, std::size_t axes) {
    std::vector<const Candidate*> firsts;
    const double least = axes > AtlasView::near_axes ? likely_wide : axes <= few_axes ? likely_few : likely;
    for (const std::size_t gait : gaits) {
      if (!(static_cast<double>(probabilities[gait]) >= least)) continue;
      const auto known = [&](const Candidate& each) { return each.gait == gait && each.sheet; };
      const auto first = std::find_if(candidates.begin(), candidates.end(), known);
      if (first != candidates.end()) firsts.push_back(&*first);
    }
    return firsts;
  }

  // The candidates of the first `top` gaits in order until one is refined; then each one left that may cost less than
  // the cheapest so far, and the `sure` ones, the most promising first: before a cliff of the cost and across its kinks
  // predictions are far off. Over more than a few axes unlikely ones are spared.
  std::vector<Attempt> attempts(const std::vector<Candidate>& candidates, const Indices& gaits,
                                const std::vector<const Candidate*>& sure, const std::vector<float>& probabilities,
                                std::size_t top, const Vector& place) {
    std::vector<Attempt> done;
    std::vector<const Candidate*> left;
    for (const Candidate& each : candidates) {
      const bool refined = !done.empty() && done.back().refined();
      if (refined || number(gaits, each.gait) >= top)
        left.push_back(&each);
      else
        done.push_back(refiner_.fast(each, place));
    }
    if (!done.back().refined()) return done;
    std::vector<std::pair<double, const Candidate*>> rivals;
    for (const Candidate* each : left) {
      const bool is_spared = each->gait != candidates.front().gait && place.size() > few_axes &&
                             static_cast<double>(probabilities[each->gait]) < unlikely;
      if (!is_spared) rivals.emplace_back(refiner_.least(*each, place), each);
    }
    std::stable_sort(rivals.begin(), rivals.end(), [](const auto& one, const auto& other) { return one.first < other.first; });
    double cost = done.back().cost;
    const bool is_surprise = cost > surprise * refiner_.least(*done.back().candidate, place);
    const double share = is_surprise && place.size() <= AtlasView::near_axes ? surprised : 1 - least_saving;
    for (const auto& [least, rival] : rivals) {
      const bool is_sure = std::find(sure.begin(), sure.end(), rival) != sure.end();
      if (!is_sure && !(least < cost * share)) continue;
      const bool is_even = is_sure && static_cast<double>(probabilities[rival->gait]) >= even;
      const Effort effort = least < cost * (1 - great_saving) ? Effort::promising : Effort::rival;
      done.push_back(refiner_.fast(*rival, place, is_even ? Effort::first : effort));
      if (done.back().refined()) cost = std::min(cost, done.back().cost);
    }
    return done;
  }

  // Refined motions by cost, then the others by violation.
  static bool cheaper(const Attempt& one, const Attempt& other) {
    if (one.refined() != other.refined()) return one.refined();
    return one.refined() ? one.cost < other.cost : one.violation < other.violation;
  }

  // Refined motions before others; of equal ones the first.
  static bool earlier(const Attempt& one, const Attempt& other) { return one.refined() && !other.refined(); }

  static std::size_t number(const Indices& gaits, std::size_t gait) {
    return static_cast<std::size_t>(std::find(gaits.begin(), gaits.end(), gait) - gaits.begin());
  }

  // How the gait that is taken came to be so, by its number and that of the first one that was refined.
  static std::string path(std::size_t taken, std::size_t solved) {
    if (taken == 0) return "fast";
    return (taken == solved ? "next:" : "cheaper:") + std::to_string(taken);
  }

  const GaitMap& map_;
  Refiner refiner_;
};

}  // namespace gaitflow
