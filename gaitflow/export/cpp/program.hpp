// A map's problem with its derivatives: what a solver asks of the generated functions.
//
//   gaitflow::Program program(GAITFLOW_FUNCTIONS, map);   // after #include "map.h"
#pragma once

#include <cstddef>
#include <stdexcept>

#include "function.hpp"
#include "map_data.hpp"

namespace gaitflow {

// The functions of one map.
struct Functions {
  Symbols problem, gradient, jacobian, hessian, nominal;
};

#define GAITFLOW_FUNCTIONS                                                               \
  gaitflow::Functions {                                                                  \
    GAITFLOW_FUNCTION(gaitflow_problem), GAITFLOW_FUNCTION(gaitflow_gradient),           \
        GAITFLOW_FUNCTION(gaitflow_jacobian), GAITFLOW_FUNCTION(gaitflow_hessian),       \
        GAITFLOW_FUNCTION(gaitflow_nominal)                                              \
  }

// For one thread: it holds the values of the last evaluation, at w [nw], a task [p] and multipliers of rows [ng].
class Program {
 public:
  // Throws std::runtime_error where the functions are not those of the map.
  Program(const Functions& functions, const MapFile& map)
      : problem_(functions.problem),
        gradient_(functions.gradient),
        jacobian_(functions.jacobian),
        hessian_(functions.hessian),
        nominal_(functions.nominal) {
    if (problem_.input_size(0) != map.layout.variables() || problem_.input_size(1) != map.task.names.size() ||
        problem_.result(1).size() != map.layout.rows || nominal_.input_size(0) != map.task.names.size() ||
        nominal_.result(0).size() != map.layout.variables())
      throw std::runtime_error("map.bin and problem.c are of different exports; export the map again");
  }

  void evaluate_rows(const Vector& w, const Vector& task) { problem_({w.data(), task.data()}); }

  void evaluate_slopes(const Vector& w, const Vector& task) {
    gradient_({w.data(), task.data()});
    jacobian_({w.data(), task.data()});
  }

  void evaluate_hessian(const Vector& w, const Vector& task, const Vector& multipliers) {
    hessian_({w.data(), task.data(), multipliers.data()});
  }

  // The decision vector [nw] of an upright glide along the task's command.
  const Vector& nominal(const Vector& task) {
    nominal_({task.data()});
    return nominal_.result(0);
  }

  std::size_t parameters() const { return problem_.input_size(1); }  // p

  double cost() const { return problem_.result(0)[0]; }
  const Vector& rows() const { return problem_.result(1); }          // [ng]
  const Vector& gradient() const { return gradient_.result(0); }     // of the cost [nw]
  const Vector& jacobian() const { return jacobian_.result(0); }     // of the rows, at its places
  const Vector& hessian() const { return hessian_.result(0); }       // of cost + multipliers * rows, upper triangle
  const Places& jacobian_places() const { return jacobian_.places(0); }
  const Places& hessian_places() const { return hessian_.places(0); }

 private:
  Function problem_, gradient_, jacobian_, hessian_, nominal_;
};

}  // namespace gaitflow
