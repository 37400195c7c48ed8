// The largest residual, as interior_point.hpp measures it, of the numbers given as arguments.
#include <cstdio>
#include <cstdlib>

#include "interior_point.hpp"

int main(int count, char** numbers) {
  double most = 0;
  for (int i = 1; i < count; ++i) most = gaitflow::larger(most, std::strtod(numbers[i], nullptr));
  std::printf("%g\n", most);
}
