// Asks an exported map about tasks: a line of values on the map's axes in, such as "0.9 0.6" (m/s, s), a JSON object a
// line out.
//
// Beside the gait and its warm start it evaluates the map's own problem there: the cost, the constraint rows, and the
// largest component of the Lagrangian's gradient over the variables that the gait leaves free. An optimiser of yours is
// given these functions, the bounds in `WarmStart::space`, and the warm start.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "function.hpp"
#include "gait_map.hpp"
#include "lines.hpp"
#include "map.h"
#include "trajectory.hpp"

namespace {

using Clock = std::chrono::steady_clock;

double microseconds(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double, std::micro>(to - from).count();
}

class Problem {
 public:
  Problem(const gaitflow::Layout& layout, std::size_t parameters)
      : value_(GAITFLOW_FUNCTION(gaitflow_problem)),
        gradient_(GAITFLOW_FUNCTION(gaitflow_gradient)),
        jacobian_(GAITFLOW_FUNCTION(gaitflow_jacobian)) {
    if (value_.input_size(0) != layout.variables() || value_.input_size(1) != parameters ||
        value_.result(1).size() != layout.rows)
      throw std::runtime_error("map.bin and problem.c are of different exports; export the map again");
  }

  void print_at(const gaitflow::WarmStart& start, const gaitflow::Vector& task) {
    value_({start.primal.data(), task.data()});
    print("cost", value_.result(0)[0]);
    print("rows", value_.result(1));
    print("stationarity", stationarity(start, task.data()));
  }

 private:
  double stationarity(const gaitflow::WarmStart& start, const double* task) {
    gradient_({start.primal.data(), task});
    jacobian_({start.primal.data(), task});
    gaitflow::Vector total = gradient_.result(0);
    for (std::size_t i = 0; i < total.size(); ++i) total[i] += start.multipliers_bounds[i];
    const gaitflow::Places& places = jacobian_.places(0);
    for (std::size_t k = 0; k < places.size(); ++k)
      total[places[k].second] += jacobian_.result(0)[k] * start.multipliers_rows[places[k].first];
    double most = 0;
    for (const std::size_t i : start.space->free) most = std::max(most, std::abs(total[i]));
    return most;
  }

  gaitflow::Function value_, gradient_, jacobian_;
};

void answer_all(const gaitflow::GaitMap& map) {
  Problem problem(map.layout(), map.file().task.names.size());
  gaitflow::Vector place(map.axes().size());
  double select_us = 0, start_us = 0;
  std::size_t tasks = 0, starts = 0;
  for (; read(place, tasks + 1); ++tasks) {
    const Clock::time_point asked = Clock::now();
    const gaitflow::Choice choice = map.select(place);
    const Clock::time_point selected = Clock::now();
    select_us += microseconds(asked, selected);
    std::printf("{\"in_domain\": %s", choice.in_domain ? "true" : "false");
    for (std::size_t axis = 0; axis < place.size(); ++axis) print(map.axes()[axis].c_str(), place[axis]);
    if (choice.gait) {
      const Clock::time_point chosen = Clock::now();
      const gaitflow::WarmStart start = map.warm_start(*choice.gait, place);
      start_us += microseconds(chosen, Clock::now());
      ++starts;
      print("gait", choice.gait->name);
      print("pattern", *start.pattern);
      print("probability", choice.probability);
      print("probabilities", gaitflow::Vector(choice.probabilities.begin(), choice.probabilities.end()));
      print("primal", start.primal);
      print("multipliers_bounds", start.multipliers_bounds);
      print("multipliers_rows", start.multipliers_rows);
      const gaitflow::Trajectory motion = gaitflow::unpack(map.layout(), start.primal, map.cycle_duration(place));
      print("times", motion.times);
      print("feet", motion.feet);
      print("end_forces", motion.end_forces);
      problem.print_at(start, map.parameters(place));
    }
    std::printf("}\n");
  }
  std::fprintf(stderr, "%zu tasks, %.1f us a select; %zu warm starts, %.1f us each\n", tasks,
               tasks ? select_us / static_cast<double>(tasks) : 0.0, starts,
               starts ? start_us / static_cast<double>(starts) : 0.0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s MAP.BIN < TASKS\n", argv[0]);
    return 2;
  }
  try {
    answer_all(gaitflow::GaitMap(argv[1]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
