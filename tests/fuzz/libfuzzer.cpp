#include <cstddef>
#include <cstdint>

#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"

/// What libFuzzer calls with every input (https://llvm.org/docs/LibFuzzer.html). An exception that
/// passes through ends the process: that is a find.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const parray::fuzz::Target& target = parray::fuzz::target_named(PARRAY_FUZZ_TARGET);
  target.run({reinterpret_cast<const char*>(data), size});
  return 0;
}
