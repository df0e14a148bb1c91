#include "cli/measure/tradeoff/analysis.h"

#include <doctest/doctest.h>

#include <vector>

#include "cli/measure/tradeoff/answer.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("a row whose measured error is not above 0 is no answer and not on the Pareto front") {
  const auto row = [](const char* options, double seconds, double rmse) {
    tradeoff::Row one;
    one.options = options;
    one.seconds = {seconds, seconds, seconds};
    one.rmse = rmse;
    return one;
  };
  std::vector<tradeoff::Row> rows{row("unknown", 1, 0), row("fast", 2, 0.5), row("slow", 3, 0.25),
                                  row("bad", 3, 0.75)};
  tradeoff::mark_front(rows);
  CHECK_FALSE(rows[0].on_front);
  CHECK(rows[1].on_front);
  CHECK(rows[2].on_front);
  CHECK(rows[3].dominated_by == "fast");
  CHECK(tradeoff::fastest_within(1, rows) == &rows[1]);
  CHECK(tradeoff::fastest_within(0.3, rows) == &rows[2]);
  CHECK(tradeoff::fastest_within(0.1, rows) == nullptr);
}

}  // namespace parray
