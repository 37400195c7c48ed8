// Calls a function that CasADi generated as C, and says where the values of its sparse results belong.
//
//   #include "map.h"
//   gaitflow::Function problem(GAITFLOW_FUNCTION(gaitflow_problem));
//   problem({w.data(), task});  // then problem.result(0) is the cost, problem.result(1) are the rows
#pragma once

#include <algorithm>
#include <cstddef>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace gaitflow {

// What a generated function NAME is called by: NAME(...), NAME_work(...), ...
struct Symbols {
  const char* name;
  int (*evaluate)(const double**, double**, long long int*, double*, int);
  int (*work)(long long int*, long long int*, long long int*, long long int*);
  long long int (*inputs)(void);
  long long int (*outputs)(void);
  const long long int* (*sparsity_in)(long long int);
  const long long int* (*sparsity_out)(long long int);
};

#define GAITFLOW_FUNCTION_(name) \
  gaitflow::Symbols { #name, name, name##_work, name##_n_in, name##_n_out, name##_sparsity_in, name##_sparsity_out }
#define GAITFLOW_FUNCTION(name) GAITFLOW_FUNCTION_(name)

using Places = std::vector<std::pair<std::size_t, std::size_t>>;  // (row, column)

// For one thread: it holds the results of the last call.
class Function {
 public:
  explicit Function(const Symbols& symbols) : symbols_(symbols) {
    long long int arguments, results, integers, numbers;
    if (symbols.work(&arguments, &results, &integers, &numbers) != 0)
      throw std::runtime_error(std::string(symbols.name) + ": does not say how much memory it needs");
    arguments_.resize(static_cast<std::size_t>(arguments));
    targets_.resize(static_cast<std::size_t>(results));
    integers_.resize(static_cast<std::size_t>(integers));
    numbers_.resize(static_cast<std::size_t>(numbers));
    for (long long int i = 0; i < symbols.outputs(); ++i) {
      places_.push_back(places_of(symbols.sparsity_out(i)));
      results_.emplace_back(places_.back().size());
    }
  }

  // How many numbers input i takes.
  std::size_t input_size(std::size_t i) const {
    return static_cast<std::size_t>(symbols_.sparsity_in(static_cast<long long int>(i))[0]);
  }

  // Evaluate at one pointer an input. Throws std::invalid_argument for another number of them.
  void operator()(std::initializer_list<const double*> inputs) {
    if (inputs.size() != static_cast<std::size_t>(symbols_.inputs()))
      throw std::invalid_argument(std::string(symbols_.name) + ": takes " + std::to_string(symbols_.inputs()) +
                                  " inputs, got " + std::to_string(inputs.size()));
    std::copy(inputs.begin(), inputs.end(), arguments_.begin());
    for (std::size_t i = 0; i < results_.size(); ++i) targets_[i] = results_[i].data();
    if (symbols_.evaluate(arguments_.data(), targets_.data(), integers_.data(), numbers_.data(), 0) != 0)
      throw std::runtime_error(std::string(symbols_.name) + ": failed");
  }

  // The values of result i, and the place of each; a dense result has them column by column.
  const std::vector<double>& result(std::size_t i) const { return results_[i]; }
  const Places& places(std::size_t i) const { return places_[i]; }

 private:
  // CasADi's pattern: rows, columns, then 1 for a dense one, or column offsets and the row of each value.
  static Places places_of(const long long int* pattern) {
    const long long int rows = pattern[0], columns = pattern[1];
    Places places;
    const auto add = [&places](long long int row, long long int column) {
      places.emplace_back(static_cast<std::size_t>(row), static_cast<std::size_t>(column));
    };
    for (long long int column = 0; column < columns; ++column) {
      if (pattern[2] != 0) {
        for (long long int row = 0; row < rows; ++row) add(row, column);
      } else {
        const long long int* row_of = pattern + 3 + columns;
        for (long long int k = pattern[2 + column]; k < pattern[3 + column]; ++k) add(row_of[k], column);
      }
    }
    return places;
  }

  Symbols symbols_;
  std::vector<const double*> arguments_;
  std::vector<double*> targets_;
  std::vector<long long int> integers_;
  std::vector<double> numbers_;
  std::vector<std::vector<double>> results_;
  std::vector<Places> places_;
};

}  // namespace gaitflow
