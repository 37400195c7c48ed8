// Plans with an exported map: a line of values on the map's axes in, such as "0.9 0.6" (m/s, s), a JSON object a line
// out. Durations of phases are in s, feet [knots, legs, d] in m; cpu_us is the time that the plan took on this core.
#include <cstdio>
#include <ctime>
#include <exception>

#include "lines.hpp"
#include "map.h"
#include "planner.hpp"

namespace {

void print_plan(const gaitflow::Plan& plan, double cpu_us) {
  print("gait", plan.gait->name);
  print("pattern", *plan.pattern);
  print("path", plan.path);
  print("cost", plan.cost);
  print("violation", plan.violation);
  print("iterations", static_cast<double>(plan.iterations));
  print("probability", plan.probability);
  print("durations", plan.motion.durations);
  print("feet", plan.motion.feet);
  print("primal", plan.primal);
  print("cpu_us", cpu_us);
  std::printf(", \"refined\": %s", plan.refined ? "true" : "false");
}

void plan_all(const gaitflow::GaitMap& map) {
  gaitflow::Planner planner(map, GAITFLOW_FUNCTIONS);  // one a thread; the map is shared
  gaitflow::Vector place(map.axes().size());
  for (std::size_t line = 1; read(place, line); ++line) {
    const std::clock_t begin = std::clock();
    const gaitflow::Plan plan = planner.plan(place);
    const double cpu_us = 1e6 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    std::printf("{\"in_domain\": %s", plan.in_domain ? "true" : "false");
    for (std::size_t axis = 0; axis < place.size(); ++axis) print(map.axes()[axis].c_str(), place[axis]);
    if (plan.gait) print_plan(plan, cpu_us);
    std::printf("}\n");
    std::fflush(stdout);  // for who waits for it at the other end of a pipe
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s MAP.BIN < TASKS\n", argv[0]);
    return 2;
  }
  try {
    plan_all(gaitflow::GaitMap(argv[1]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
