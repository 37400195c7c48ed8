// What refines motions, as a library with C functions that any language can call; gaitflow/runtime/compiled.py does.
//
// A call that fails returns a null pointer or -1, and `gaitflow_error` says why.
#include <cstddef>
#include <exception>
#include <stdexcept>
#include <string>

#include "map.h"
#include "refine.hpp"

namespace {

thread_local std::string last_error;

// What `call` returns, or `failed` where it throws.
template <typename Result, typename Call>
Result guarded(Result failed, const Call& call) {
  try {
    return call();
  } catch (const std::exception& error) {
    last_error = error.what();
    return failed;
  }
}

}  // namespace

extern "C" {

// Counts up when these functions change.
unsigned gaitflow_interface() { return 1; }

// What went wrong in the last call of this thread that failed.
const char* gaitflow_error() { return last_error.c_str(); }

// The map in a file, for any number of threads; to be closed after all its refiners.
gaitflow::GaitMap* gaitflow_open(const char* path) {
  return guarded<gaitflow::GaitMap*>(nullptr, [path] { return new gaitflow::GaitMap(path); });
}

void gaitflow_close(gaitflow::GaitMap* map) { delete map; }

// The SHA-256 [32] of the manifest of the map that was exported.
const unsigned char* gaitflow_manifest_sha256(const gaitflow::GaitMap* map) { return map->file().manifest_sha256.data(); }

// A map's gaits, each with its matrices, for one thread.
gaitflow::Refiner* gaitflow_new_refiner(const gaitflow::GaitMap* map) {
  return guarded<gaitflow::Refiner*>(nullptr, [map] { return new gaitflow::Refiner(*map, GAITFLOW_FUNCTIONS); });
}

void gaitflow_delete_refiner(gaitflow::Refiner* refiner) { delete refiner; }

// Refines gait number `gait` by a sheet of the atlas, or from its region's mean where `sheet` is -1, at a place [axes],
// with an `Effort` of 1 to 3: a motion [nw], and its cost in the scenario's units. Returns 1 where it converged, else 0.
int gaitflow_refine(gaitflow::Refiner* refiner, const gaitflow::GaitMap* map, std::size_t gait, std::ptrdiff_t sheet,
                    const double* place, std::size_t effort, double* motion, double* cost, std::size_t* iterations) {
  return guarded<int>(-1, [&] {
    const auto& sheets = map->file().atlas.sheets;
    if (gait >= map->gaits().size() || sheet < -1 || sheet >= static_cast<std::ptrdiff_t>(sheets.size()))
      throw std::invalid_argument("the map has no such gait or sheet");
    const gaitflow::Candidate candidate{gait, sheet < 0 ? nullptr : &sheets[static_cast<std::size_t>(sheet)]};
    if (effort < 1 || effort > 3) throw std::invalid_argument("an effort is 1, 2 or 3");
    const gaitflow::Vector asked(place, place + map->axes().size());
    const gaitflow::Attempt attempt = refiner->fast(candidate, asked, static_cast<gaitflow::Effort>(effort));
    std::copy(attempt.primal.begin(), attempt.primal.end(), motion);
    *cost = attempt.cost;
    *iterations = attempt.iterations;
    return attempt.ending == gaitflow::Ending::converged ? 1 : 0;
  });
}

}  // extern "C"
