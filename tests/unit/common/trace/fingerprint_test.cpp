#include "common/trace/selfcheck/fingerprint.h"

#include <doctest/doctest.h>

#include "tests/support/rooms.h"

namespace parray::test {

// For every compiler, optimisation level and sanitizer. When a change to the tracer changes the
// picture on purpose, raise trace_version (proto/messages.h) with the pinned hash.
TEST_CASE("every build of this trace version traces the same bits") {
  CHECK(trace_fingerprint() == pinned_fingerprint);
}

}  // namespace parray::test
