#include "common/trace/fingerprint.h"

#include <doctest/doctest.h>

namespace parray::test {

// The hash of the built-in picture, for every compiler, optimisation level and sanitizer. When a
// change to the tracer changes it on purpose, raise trace_version (proto/messages.h) with it.
TEST_CASE("every build of this trace version traces the same bits") {
  CHECK(trace_fingerprint() == "7d7264c5a9088034839058de2ce14a10e0d88fe1dce74b0bdf9fae899212341f");
}

}  // namespace parray::test
