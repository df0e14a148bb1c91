#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "common/process/command_line.h"
#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("given options have the last value, those whose order matters have all values in order") {
  CommandLine line;
  const auto ignore = [](const std::string& /*text*/) {};
  std::string name;
  bool quiet = false;
  bool wrap = false;
  line.flag("--wrap", wrap, "").in_order();
  line.option("--show", ignore, "").group("particles").in_order();
  line.option("--color", ignore, "").in_order();
  line.option("--style", ignore, "");
  line.option("-n,--name", name, "");
  line.flag("--quiet", quiet, "");
  line.option("--unused", ignore, "");
  line.parse("--show a --color x --style s --show b --wrap -n one --style t --quiet --color y");
  std::string text;
  for (const GivenOption& given : line.given_options()) {
    text += given.group + given.name + "=" + given.value + " ";
  }
  CHECK(text ==
        "Options--style=t Options--name=one Options--quiet= particles--show=a Options--color=x "
        "particles--show=b Options--wrap= Options--color=y ");
}

TEST_CASE("a value of an environment variable is no given option") {
  CommandLine line;
  std::string path;
  line.option("--path", path, "").environment("PATH");
  line.parse("");
  CHECK_FALSE(path.empty());
  CHECK(line.given_options().empty());
  line.parse("--path x");
  REQUIRE(line.given_options().size() == 1);
  CHECK(line.given_options().front().value == "x");
}

}  // namespace parray
