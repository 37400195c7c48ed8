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
#include <optional>
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

// gait and pattern point into the map; nullptr outside its domain, where nothing is tried. refined: converged, and no row
// or bound of the problem is off by more than 1e-6; otherwise the motion is the least infeasible one. cost in the
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

// For one thread; planners of one map share it. Making one takes memory and some milliseconds a gait, a plan takes none
// but for its own and its starts'.
class Planner {
 public:
  // Throws std::runtime_error where the functions are not those of the map, which has to live as long.
  Planner(const GaitMap& map, const Functions& functions) : map_(map), refiner_(map, functions) {}

  // A plan for a place, from `top` gaits at most. Throws std::invalid_argument for a number that is not finite.
  Plan plan(const Vector& place, std::size_t top = 3) {
    Plan plan;
    plan.in_domain = map_.contains(place);
    if (!plan.in_domain) return plan;
    const std::vector<float> probabilities = map_.probabilities(place);
    std::vector<Candidate> candidates = map_.candidates(place, probabilities);
    candidates.resize(std::min(candidates.size(), std::max<std::size_t>(top, 1)));
    const std::vector<Attempt> attempts = this->attempts(candidates, place);
    const Attempt& best = *std::min_element(attempts.begin(), attempts.end(), cheaper);
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
    if (plan.refined) plan.path = path(attempts, static_cast<std::size_t>(&taken - candidates.data()));
    plan.primal = best.primal;
    plan.motion = unpack(map_.layout(), plan.primal, map_.cycle_duration(place));
    return plan;
  }

 private:
  // The candidates in order until one is refined. Where another one may cost less than that came to, it is refined as
  // well: before a cliff of the cost, predictions are far off.
  std::vector<Attempt> attempts(const std::vector<Candidate>& candidates, const Vector& place) {
    std::vector<Attempt> done;
    auto next = candidates.begin();
    do {
      done.push_back(refiner_.fast(*next++, place));
    } while (!done.back().refined() && next != candidates.end());
    if (!done.back().refined()) return done;
    double least = worth_a_look(done.back());
    const Candidate* rival = nullptr;
    for (; next != candidates.end(); ++next) {
      const double promised = refiner_.least(*next, place);
      if (promised < least) least = promised, rival = &*next;
    }
    if (rival) done.push_back(refiner_.fast(*rival, place, 1));
    return done;
  }

  // The cost below which another gait's promise is looked at: where this one's was off, the other may be as well.
  static double worth_a_look(const Attempt& attempt) {
    constexpr double least_saving = 1e-3, much = 1e-2;  // relative
    const double off = attempt.expected > 0 ? std::abs(attempt.cost / attempt.expected - 1) : 0.0;
    return attempt.cost * (1 - least_saving) * (1 + (much < off && std::isfinite(off) ? off : 0.0));
  }

  // Refined motions by cost, then the others by violation.
  static bool cheaper(const Attempt& one, const Attempt& other) {
    if (one.refined() != other.refined()) return one.refined();
    return one.refined() ? one.cost < other.cost : one.violation < other.violation;
  }

  // How the gait at a place among the candidates came to be taken.
  static std::string path(const std::vector<Attempt>& attempts, std::size_t place) {
    const auto first = std::find_if(attempts.begin(), attempts.end(), [](const Attempt& each) { return each.refined(); });
    const bool was_first = static_cast<std::size_t>(first - attempts.begin()) == place;
    if (!was_first) return "cheaper:" + std::to_string(place);
    return place == 0 ? "fast" : "next:" + std::to_string(place);
  }

  const GaitMap& map_;
  Refiner refiner_;
};

}  // namespace gaitflow
