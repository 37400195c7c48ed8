// A decision vector of the map's problem as a motion in SI units.
#pragma once

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "map_data.hpp"

namespace gaitflow {

// SI units, terrain frame. times [K+1]; base [K+1, nb]; feet [K+1, legs, d]; forces, end_forces, foot_velocities
// [K, legs, d]; durations [phases]. In step k, from knot k to k+1, a foot moves at its velocity and its force runs
// linearly from forces[k] to end_forces[k]; held forces have the two equal.
struct Trajectory {
  Vector times, base, feet, forces, end_forces, foot_velocities, durations;
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
  const std::size_t feet = layout.feet(), knots = layout.knots_per_phase;
  Vector last;  // forces at the end of each phase
  take(last, layout.ends(), 1.0);
  take(motion.durations, layout.phases, cycle_duration);
  motion.end_forces = motion.forces;
  for (std::size_t step = 0; layout.linear_forces && step < layout.steps(); ++step) {
    const bool ends = (step + 1) % knots == 0;
    const double* from = ends ? last.data() + step / knots * feet : motion.forces.data() + (step + 1) * feet;
    std::copy(from, from + feet, motion.end_forces.begin() + static_cast<std::ptrdiff_t>(step * feet));
  }
  motion.times.push_back(0.0);
  for (std::size_t step = 0; step < layout.steps(); ++step)
    motion.times.push_back(motion.times.back() + motion.durations[step / knots] * layout.shares[step % knots]);
  return motion;
}

}  // namespace gaitflow
