#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/process/command_line.h"
#include "common/process/description.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

std::string refusal_of(const std::string& example) {
  bool fast = false;
  const auto declare = [&](CommandLine& line) {
    Command go = line.command("go", "Go");
    go.flag("--fast", fast, "Fast");
    go.example(example, "fast");
  };
  try {
    describe(declare, "prog", "About");
  } catch (const RunError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("an example that the program does not understand is refused, with the reason") {
  CHECK(refusal_of("prog go --fast").empty());
  CHECK(refusal_of("env X=1 prog go --fast &").empty());
  CHECK(refusal_of("prog go --fats") ==
        "the example 'prog go --fats': unknown option --fats: did you mean --fast? See `prog go "
        "--help`");
  CHECK(refusal_of("go --fast") == "the example 'go --fast': it does not name prog");
}

TEST_CASE("an example is split into words as in a shell") {
  using Words = std::vector<std::string>;
  CHECK(shell_words("") == Words{});
  CHECK(shell_words("  a  b ") == Words{"a", "b"});
  CHECK(shell_words("a 'b c' \"d'e\" f'g'h ''") == Words{"a", "b c", "d'e", "fgh", ""});
  CHECK(shell_words("a b#c # d") == Words{"a", "b#c"});
  CHECK(shell_words("a b & c") == Words{"a", "b"});
}

TEST_CASE("text is wrapped between words, and a word that is too long has its own line") {
  CHECK(wrapped("", 2, 10).empty());
  CHECK(wrapped("one two", 0, 7) == "one two");
  CHECK(wrapped("one two", 0, 6) == "one\ntwo");
  CHECK(wrapped("one two  three", 2, 9) == "one two\n  three");
  CHECK(wrapped("a incomprehensibilities b", 1, 5) == "a\n incomprehensibilities\n b");
}

}  // namespace parray
