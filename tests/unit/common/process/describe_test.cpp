#include "common/process/describe.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "common/base/error.h"
#include "common/process/command_line.h"
#include "common/process/help_text.h"
#include "common/process/manual_page.h"
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
    describe(declare, "prog", "About", "/dev/null/none");
  } catch (const RunError& error) {
    const std::string reason = error.what();
    return reason.starts_with("making ") ? "" : reason;  // understood; but that is no directory
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

TEST_CASE("the words of an example are those of a shell") {
  using Words = std::vector<std::string>;
  CHECK(shell_words("") == Words{});
  CHECK(shell_words("  a  b ") == Words{"a", "b"});
  CHECK(shell_words("a 'b c' \"d'e\" f'g'h ''") == Words{"a", "b c", "d'e", "fgh", ""});
  CHECK(shell_words("a b#c # d") == Words{"a", "b#c"});
  CHECK(shell_words("a b & c") == Words{"a", "b"});
}

TEST_CASE("text is wrapped between words, and a word that is too long stands alone") {
  CHECK(wrapped("", 2, 10).empty());
  CHECK(wrapped("one two", 0, 7) == "one two");
  CHECK(wrapped("one two", 0, 6) == "one\ntwo");
  CHECK(wrapped("one two  three", 2, 9) == "one two\n  three");
  CHECK(wrapped("a incomprehensibilities b", 1, 5) == "a\n incomprehensibilities\n b");
}

TEST_CASE("a man page shows text as it is, whatever troff would make of it") {
  ProgramText program;
  program.self.name = "prog";
  program.self.about = "Show .dots";
  program.self.manual =
      ".dot at the beginning\n'quote' and \\back, `--literal`\n\n- point one\n  goes on\n\n"
      "    literal 'block' \\n\n\n# Heading\nlast\n";
  const std::string page = manual_page(program);
  const auto has = [&](const std::string& text) { return page.find(text) != std::string::npos; };
  CHECK(has("\n\\&.dot at the beginning\n"));
  CHECK(has("\n\\(aqquote\\(aq and \\eback, \\fB\\-\\-literal\\fR\n"));
  CHECK(has("\n.IP \\(bu 2\npoint one\ngoes on\n"));
  CHECK(has("\n.EX\n\\&literal \\(aqblock\\(aq \\en\n.EE\n"));
  CHECK(has("\n.SH \"HEADING\"\nlast\n"));
}

}  // namespace parray
