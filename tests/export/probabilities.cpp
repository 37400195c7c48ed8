// Probabilities by a map's classifier, a line for each place on standard input; the map's functions are not needed.
#include <exception>
#include <iomanip>
#include <iostream>

#include "gait_map.hpp"

int main(int, char** arguments) {
  try {
    const gaitflow::GaitMap map(arguments[1]);
    gaitflow::Vector place(map.axes().size());
    std::cout << std::setprecision(9);
    while (true) {
      for (double& value : place) std::cin >> value;
      if (!std::cin) return 0;
      for (const float probability : map.probabilities(place)) std::cout << probability << ' ';
      std::cout << '\n';
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
