#include "common/trace/fingerprint.h"

#include <doctest/doctest.h>

namespace parray::test {

// The hash of the built-in picture, for every compiler, optimisation level and sanitizer. When a
// change to the tracer changes it on purpose, raise trace_version (proto/messages.h) with it.
TEST_CASE("every build of this trace version traces the same bits") {
  CHECK(trace_fingerprint() == "8a96c4160de56afb48d20bce91849a95a438eece173e7b0bcf45624cc50a12df");
}

}  // namespace parray::test
