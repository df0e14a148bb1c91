#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/support/rooms.h"
#include "tests/support/trials.h"

/// Random seeds and a table of results for the tests in tests/extremes.
namespace parray::test {

/// Returns `seed` for this run. PARRAY_EXTREMES_SEED selects other random cases.
inline std::uint64_t seeded(std::uint64_t seed) {
  return seed + 1'000'003 * environment_number("PARRAY_EXTREMES_SEED", 0);
}

/// Returns `what` with the name of the precision after it.
template <typename Real>
std::string named(const std::string& what) {
  return what + (sizeof(Real) == sizeof(float) ? ", f32" : ", f64");
}

/// Checks that the worst value is within its tolerance. Writes both to the table that
/// PARRAY_EXTREMES_TABLE names (see tests/extremes/table).
inline void within(int row, const std::string& what, double worst, double tolerance) {
  CAPTURE(what);
  CHECK(worst <= tolerance);                                       // false for NaN
  const char* const table = std::getenv("PARRAY_EXTREMES_TABLE");  // NOLINT(concurrency-mt-unsafe)
  if (table != nullptr) {
    std::ofstream(table, std::ios::app)
        << row << '\t' << what << '\t' << worst << '\t' << tolerance << '\n';
  }
}

}  // namespace parray::test
