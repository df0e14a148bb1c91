#include "coordinator/loop/rate_history.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "tests/support/rooms.h"

namespace parray {
namespace {

using Rates = std::vector<float>;

TEST_CASE("the rates of an hour are kept, and nothing older") {
  RateHistory history;
  for (int i = 0; i < 1000; ++i) {
    history.add(seconds(10 * i + 3), 10.0 * i);
    history.add(seconds(10 * i + 7), 10);
  }
  const Rates rates = history.before(1000, RateHistory::most + 5);
  REQUIRE(rates.size() == RateHistory::most + 5);
  CHECK(rates.back() == 1000);  // of interval 999: (9990 + 10) / 10 s
  CHECK(rates[5] == 641);       // of interval 640
  CHECK(rates[0] == 0);         // forgotten
}

TEST_CASE("intervals without an amount count as 0, before, between and after those with one") {
  RateHistory history;
  history.add(seconds(25), 50);
  history.add(seconds(51), 20);
  CHECK(history.before(8, 8) == Rates{0, 0, 5, 0, 0, 2, 0, 0});
  CHECK(history.before(3, 1) == Rates{5});
  CHECK(RateHistory().before(3, 2) == Rates{0, 0});
}

TEST_CASE("a pause of years costs no more than an hour") {
  RateHistory history;
  history.add(seconds(1), 50);
  history.add(std::chrono::hours(24 * 365 * 10), 70);
  const auto end = RateHistory::number_of(std::chrono::hours(24 * 365 * 10)) + 1;
  const Rates rates = history.before(end, RateHistory::most);
  CHECK(rates.back() == 7);
  CHECK(std::ranges::count(rates, 0.0F) == RateHistory::most - 1);
}

TEST_CASE("the rate of the last minute is that of a young farm, too, and falls to 0 afterwards") {
  RateHistory history;
  history.add(seconds(100), 600);
  CHECK(history.last_minute(seconds(110), seconds(90)) == doctest::Approx(30));
  CHECK(history.last_minute(seconds(160), seconds(0)) == doctest::Approx(10));
  CHECK(history.last_minute(seconds(170), seconds(0)) == 0);
  CHECK(RateHistory().last_minute(seconds(5), never) == 0);
}

TEST_CASE("the rates of workers add up to the rate of the farm") {
  RateHistory farm;
  RateHistory one;
  RateHistory two;
  for (int second = 0; second < 100; ++second) {
    one.add(seconds(second), 3);
    farm.add(seconds(second), 3);
    if (second > 70) {
      two.add(seconds(second), 5);
      farm.add(seconds(second), 5);
    }
  }
  const Time now = seconds(103);
  CHECK(one.last_minute(now, Time(0)) + two.last_minute(now, Time(0)) ==
        doctest::Approx(farm.last_minute(now, Time(0))));
}

}  // namespace
}  // namespace parray
