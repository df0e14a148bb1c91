#include "common/adaptive/rounding_limit.h"

#include <doctest/doctest.h>

#include <string>

#include "common/base/error.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

std::string refusal(const StopSettings& settings, double largest) {
  try {
    check_targets(settings, largest);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

StopSettings to_error(double error) {
  StopSettings settings;
  settings.target_error = error;
  return settings;
}

TEST_CASE("a target below twice the rounding error is refused with the least that is accepted") {
  const std::string said = refusal(to_error(1e-9), 1);
  CHECK(said.starts_with("--target-error 1e-09 is too small: "));
  CHECK(said.ends_with("use 4.6e-08 or more"));
  CHECK(refusal(to_error(4.6e-8), 1).empty());
}

TEST_CASE("the least target grows with the scene's light") {
  CHECK(refusal(to_error(1e-6), 1).empty());
  CHECK(refusal(to_error(1e-6), 100).ends_with("use 4.6e-06 or more"));
  CHECK(refusal(to_error(1e-9), 1e-3).empty());
  CHECK(refusal(to_error(1e-9), 0).empty());
}

TEST_CASE("half-widths have the same least, and a picture without targets has none") {
  StopSettings settings;
  CHECK(refusal(settings, 1).empty());
  settings.target_half_width = 1e-9;
  CHECK(refusal(settings, 1).starts_with("--target-half-width 1e-09 is too small: "));
}

TEST_CASE("a recipe's passes repeat a picture whatever its target was") {
  StopSettings settings = to_error(1e-9);
  settings.passes = {100, 100};
  CHECK(refusal(settings, 1).empty());
}

TEST_CASE("an aim below the option's value raises the least of the option") {
  CHECK_NOTHROW(check_above_rounding("--error", 5e-8, 1));
  CHECK_THROWS_AS(check_above_rounding("--error", 5e-8, 1, 0.9), InputError);
}

}  // namespace
}  // namespace parray
