#pragma once

#include <cstdint>
#include <cstdlib>

/// How many random cases a test tries.
namespace parray::test {

inline std::uint64_t environment_number(const char* name, std::uint64_t otherwise) {
  const char* const text =
      std::getenv(name);  // NOLINT(concurrency-mt-unsafe): no thread changes it
  return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// Returns the number of trials: `usual` times PARRAY_TRIALS (default 1). The entries of ctest with
/// the label `long` set it.
inline std::uint64_t trials(std::uint64_t usual) {
  return usual * environment_number("PARRAY_TRIALS", 1);
}

}  // namespace parray::test
