#include "cli/output/labels/round_numbers.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("marks are few, round and ascending, and lie in their range") {
  for (const auto& row : std::vector<std::pair<double, double>>{{0, 1},
                                                                {-1, 1},
                                                                {-0.37, 0.91},
                                                                {3, 3.1},
                                                                {1e-9, 3e-9},
                                                                {-4e7, 1e8},
                                                                {0, 7},
                                                                {1e17, 1.0000001e17},
                                                                {-1e308, 1e308},
                                                                {-1.79e308, 1.79e308},
                                                                {0, 5e-324},
                                                                {99.99, 100.02}}) {
    const auto& [low, high] = row;  // which Clang 14 does not capture
    CAPTURE(row.first);
    CAPTURE(row.second);
    for (const std::size_t most : {2U, 3U, 6U}) {
      const Ticks ticks = ticks_between(low, high, static_cast<int>(most));
      CHECK(!ticks.values.empty());
      CHECK(ticks.values.size() <= most);
      CHECK(std::ranges::is_sorted(ticks.values));
      CHECK(ticks.values.front() >= low);
      CHECK(ticks.values.back() <= high);
      CHECK(ticks.texts.size() == ticks.values.size());
      for (const std::string& text : ticks.texts) CHECK(text.size() < 32);
    }
  }
  const Ticks ticks = ticks_between(-0.25, 0.6, 6);
  CHECK(ticks.texts == std::vector<std::string>{"\u22120.2", "0.0", "0.2", "0.4", "0.6"});
  CHECK(ticks.exponent == 0);
}

TEST_CASE("long numbers have a common power of ten") {
  const Ticks large = ticks_between(0, 2.5e6, 6);
  CHECK(large.exponent == 6);
  CHECK(large.texts == std::vector<std::string>{"0.0", "0.5", "1.0", "1.5", "2.0", "2.5"});
  CHECK(ticks_between(0, 4e-4, 6).exponent == -4);
  CHECK(power_of_ten(-4) == "10\u207b\u2074");
  CHECK(power_of_ten(12) == "10\u00b9\u00b2");
}

TEST_CASE("a logarithmic scale has marks at powers of ten, and at 2 and 5 if there is room") {
  const Ticks wide = log_ticks_between(0.02, 3e7, 6);
  REQUIRE(wide.values.size() >= 3);
  for (const double value : wide.values) {
    CHECK(std::log10(value) == doctest::Approx(std::round(std::log10(value))));
  }
  CHECK(wide.exponent == 0);
  CHECK(wide.values.size() <= 6);
  CHECK(log_ticks_between(1, 12, 6).texts == std::vector<std::string>{"1", "2", "5", "10"});
  CHECK(log_ticks_between(0.1, 1, 4).texts == std::vector<std::string>{"0.1", "0.2", "0.5", "1"});
  CHECK(log_ticks_between(2.1, 2.2, 6).texts == ticks_between(2.1, 2.2, 6).texts);
  const Ticks extreme = log_ticks_between(1e-300, 1e300, 6);
  CHECK(extreme.values.size() <= 6);
  CHECK(extreme.texts.front().starts_with("10\u207b"));
}

TEST_CASE("the marks of a logarithmic scale at the ends of double's range are in the scale") {
  constexpr double least = std::numeric_limits<double>::denorm_min();
  constexpr double most = std::numeric_limits<double>::max();
  const Ticks high = log_ticks_between(1e307, most, 6);
  CHECK(high.values.back() == doctest::Approx(1e308));
  CHECK(high.texts.back() == power_of_ten(308));
  const Ticks low = log_ticks_between(least, 2 * least, 6);
  CHECK(low.values == std::vector<double>{least});
}

TEST_CASE("round numbers are 1, 2 or 5 times a power of ten, above or below the value") {
  for (const double value : {1e-300, 0.0031, 0.1, 0.99, 1.0, 3.0, 5.0, 7.2, 1e5, 6e300}) {
    CHECK(round_below(value) <= value * (1 + 1e-5));
    CHECK(round_below(value) > value / 2.6);
    CHECK(round_above(value) >= value * (1 - 1e-5));
    CHECK(round_above(value) < value * 2.6);
  }
  CHECK(round_below(0.1F) == doctest::Approx(0.1));
  CHECK(round_above(2.0001) == 5);
}

}  // namespace parray
