// A loop at 50 Hz on an exported map, while the speed that is asked for rises from the map's least to its greatest. Each
// turn plans anew; ten times a second a line says the time, the speed, the gait, and how long the plan took.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <thread>

#include "map.h"
#include "planner.hpp"

namespace {

using Clock = std::chrono::steady_clock;
constexpr int rate = 50;  // Hz
constexpr int turns_a_line = 5;

double milliseconds(Clock::duration passed) { return std::chrono::duration<double, std::milli>(passed).count(); }

std::size_t speed_axis(const gaitflow::GaitMap& map) {
  const auto& axes = map.axes();
  const auto found = std::find(axes.begin(), axes.end(), "speed");
  if (found == axes.end()) throw std::runtime_error("the map holds the speed at one value: there is nothing to change");
  return static_cast<std::size_t>(found - axes.begin());
}

// The middle of every axis but the speed, which is a part of its way from the least to the greatest.
gaitflow::Vector place_at(const gaitflow::GaitMap& map, double part) {
  gaitflow::Vector place;
  for (std::size_t axis = 0; axis < map.axes().size(); ++axis) {
    const gaitflow::Vector& values = map.file().domain.axes[axis];
    const double along = axis == speed_axis(map) ? part : 0.5;
    place.push_back(values.front() + along * (values.back() - values.front()));
  }
  return place;
}

void follow(const gaitflow::GaitMap& map, double seconds) {
  gaitflow::Planner planner(map, GAITFLOW_FUNCTIONS);  // one a thread
  const std::size_t speed = speed_axis(map);
  const int ticks = std::max(1, static_cast<int>(seconds * rate));
  const Clock::time_point start = Clock::now();
  double longest = 0;
  int late = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    const Clock::time_point due = start + std::chrono::milliseconds(1000 * tick / rate);
    std::this_thread::sleep_until(due);
    const gaitflow::Vector place = place_at(map, static_cast<double>(tick) / ticks);
    const Clock::time_point asked = Clock::now();
    const gaitflow::Plan plan = planner.plan(place);
    const double took = milliseconds(Clock::now() - asked);
    longest = std::max(longest, took);
    late += Clock::now() > due + std::chrono::milliseconds(1000 / rate);
    if (tick % turns_a_line != 0) continue;
    std::printf("%5.2f s  %5.2f m/s  %-24s  %.2f ms%s\n", static_cast<double>(tick) / rate, place[speed],
                plan.gait ? plan.gait->name.c_str() : "outside the map's domain", took,
                plan.gait && !plan.refined ? ", not feasible" : "");
  }
  std::printf("%d turns, %d late, the longest plan took %.2f ms\n", ticks, late, longest);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 3) {
    std::fprintf(stderr, "usage: %s MAP.BIN [SECONDS]\n", argv[0]);
    return 2;
  }
  try {
    follow(gaitflow::GaitMap(argv[1]), argc == 3 ? std::atof(argv[2]) : 5.0);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
