// A decision vector of the map's problem as a motion in SI units.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "map_data.hpp"

namespace gaitflow {

// SI units, terrain frame. times [K+1]; base [K+1, nb]; feet [K+1, legs, d]; forces, foot_velocities [K, legs, d];
// durations [phases]. Controls k act from knot k to k+1.
struct Trajectory {
  Vector times, base, feet, forces, foot_velocities, durations;
};

// The motion in a decision vector [nw], such as WarmStart::primal, for a cycle duration [s].
inline Trajectory unpack(const Layout& layout, const Vector& primal, double cycle_duration) {
  if (primal.size() != layout.variables())
    throw std::invalid_argument("primal has " + std::to_string(primal.size()) + " numbers; the map's problem has " +
                                std::to_string(layout.variables()));
  Trajectory motion;
  std::size_t at = 0;
  const auto take = [&](Vector& to, std::size_t count, double factor) {
    for (const std::size_t end = at + count; at < end; ++at) to.push_back(primal[at] * layout.scale[at] * factor);
  };
  for (std::size_t knot = 0; knot <= layout.steps(); ++knot) {
    take(motion.base, layout.base, 1.0);
    take(motion.feet, layout.feet(), 1.0);
    if (knot == layout.steps()) break;
    take(motion.forces, layout.feet(), 1.0);
    take(motion.foot_velocities, layout.feet(), 1.0);
  }
  take(motion.durations, layout.phases, cycle_duration);
  const double knots = static_cast<double>(layout.knots_per_phase);
  motion.times.push_back(0.0);
  for (std::size_t step = 0; step < layout.steps(); ++step)
    motion.times.push_back(motion.times.back() + motion.durations[step / layout.knots_per_phase] / knots);
  return motion;
}

}  // namespace gaitflow
