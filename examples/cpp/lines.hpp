// Tasks in, a line each; numbers out, as members of a JSON object.
#pragma once

#include <cstddef>
#include <cstdio>
#include <iostream>
#include <stdexcept>
#include <string>

#include "map_data.hpp"

inline void print(const char* name, double value) { std::printf(", \"%s\": %.17g", name, value); }

inline void print(const char* name, const gaitflow::Vector& values) {
  std::printf(", \"%s\": [", name);
  for (std::size_t i = 0; i < values.size(); ++i) std::printf(i == 0 ? "%.17g" : ", %.17g", values[i]);
  std::printf("]");
}

inline void print(const char* name, const std::string& text) { std::printf(", \"%s\": \"%s\"", name, text.c_str()); }

// The place in the next line; false at the end of the input. Throws for anything but numbers, and for too few of them.
inline bool read(gaitflow::Vector& place, std::size_t line) {
  for (double& value : place) {
    if (std::cin >> value) continue;
    if (&value == &place.front() && std::cin.eof()) return false;
    throw std::runtime_error("line " + std::to_string(line) + ": write " + std::to_string(place.size()) +
                             " numbers, a value for each of the map's axes");
  }
  return true;
}
