#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/support/rooms.h"

/// Trials, seeds and reports of the tests of numerical extremes.
namespace parray::test {

inline std::uint64_t environment_number(const char* name, std::uint64_t otherwise) {
  const char* const text =
      std::getenv(name);  // NOLINT(concurrency-mt-unsafe): no thread changes it
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// Returns the number of trials: `usual` times PARRAY_EXTREMES_DEEP (default 1).
inline std::uint64_t trials(std::uint64_t usual) {
  return usual * environment_number("PARRAY_EXTREMES_DEEP", 1);
}

/// Returns `seed` for this run. PARRAY_EXTREMES_SEED selects other random cases.
inline std::uint64_t seeded(std::uint64_t seed) {
  return seed + 1'000'003 * environment_number("PARRAY_EXTREMES_SEED", 0);
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
