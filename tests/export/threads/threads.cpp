// Four threads plan the same tasks with a planner each and one map. Says how many of their plans are the same, number by
// number.
#include <cstdio>
#include <iostream>
#include <thread>
#include <vector>

#include "map.h"
#include "planner.hpp"

int main(int, char** argv) {
  const gaitflow::GaitMap map(argv[1]);
  std::vector<gaitflow::Vector> tasks;
  for (gaitflow::Vector place(map.axes().size());; tasks.push_back(place)) {
    for (double& value : place) std::cin >> value;
    if (!std::cin) break;
  }
  std::vector<std::vector<gaitflow::Plan>> plans(4);
  std::vector<std::thread> threads;
  for (auto& own : plans)
    threads.emplace_back([&map, &tasks, &own] {
      gaitflow::Planner planner(map, GAITFLOW_FUNCTIONS);
      for (const gaitflow::Vector& place : tasks) own.push_back(planner.plan(place));
    });
  for (std::thread& each : threads) each.join();
  std::size_t same = 0;
  for (const auto& own : plans)
    for (std::size_t i = 0; i < tasks.size(); ++i)
      same += own[i].gait == plans[0][i].gait && own[i].primal == plans[0][i].primal;
  std::printf("%zu of %zu\n", same, 4 * tasks.size());
}
