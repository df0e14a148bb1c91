#include "common/log/log.h"

#include <doctest/doctest.h>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/spdlog.h>

#include "tests/support/rooms.h"

namespace parray {
namespace {

TEST_CASE("the last lines of a log are kept, oldest first, without their ends") {
  spdlog::logger log("test", std::make_shared<spdlog::sinks::null_sink_st>());
  const auto lines = keep_lines(log, 3);
  CHECK(lines().empty());
  for (int i = 0; i < 5; ++i) log.warn("line {}", i);
  log.debug("below the level of the log");
  const std::vector<std::string> kept = lines();
  REQUIRE(kept.size() == 3);
  CHECK(kept[0].ends_with("warning: line 2"));
  CHECK(kept[2].ends_with("warning: line 4"));
}

TEST_CASE("a name with control characters stays in its line of the log, as escapes") {
  spdlog::logger log("test", std::make_shared<spdlog::sinks::null_sink_st>());
  const auto lines = keep_lines(log, 3);
  log.warn("worker '{}'", "a\x1b[31mb\nINJECT");
  REQUIRE(lines().size() == 1);
  CHECK(lines().front().ends_with("warning: worker 'a\\x1b[31mb\\x0aINJECT'"));
}

}  // namespace
}  // namespace parray
