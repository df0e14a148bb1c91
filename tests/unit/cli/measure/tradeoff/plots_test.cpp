#include <doctest/doctest.h>

#include "cli/measure/tradeoff/tradeoff_results.h"
#include "cli/output/picture/partial_file.h"
#include "common/base/error.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray {

TEST_CASE("a file in the place of the folder of plots ends with a message") {
  const test::TemporaryDirectory directory;
  write_text_file(directory.path() / "plots", "");
  CHECK_THROWS_AS(tradeoff::write_plot_scripts(tradeoff::TradeoffResults(), directory.path()),
                  RunError);
}

}  // namespace parray
