// Asks an exported map about tasks, a place a line; a line of answers out. Exit code 3 says that a number is not finite.
#include <cmath>
#include <cstdio>
#include <exception>

#include "gait_map.hpp"
#include "lines.hpp"
#include "trajectory.hpp"

namespace {

bool finite(const gaitflow::Vector& values) {
  for (const double value : values)
    if (!std::isfinite(value)) return false;
  return true;
}

bool answer_all(const gaitflow::GaitMap& map) {
  gaitflow::Vector place(map.axes().size());
  for (std::size_t line = 1; read(place, line); ++line) {
    const gaitflow::Choice choice = map.select(place);
    std::printf("%s", choice.in_domain ? choice.gait->pattern.c_str() : "outside");
    if (choice.gait) {
      const gaitflow::WarmStart start = map.warm_start(*choice.gait, place);
      const gaitflow::Trajectory motion = gaitflow::unpack(map.layout(), start.primal, map.cycle_duration(place));
      if (!std::isfinite(choice.probability) || !finite(start.primal) || !finite(start.multipliers_bounds) ||
          !finite(start.multipliers_rows) || !finite(motion.times) || !finite(motion.feet))
        return false;
    }
    std::printf("\n");
  }
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  try {
    return answer_all(gaitflow::GaitMap(argv[1])) ? 0 : 3;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
