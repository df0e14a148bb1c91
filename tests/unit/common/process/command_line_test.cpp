#include "common/process/command_line.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray::test {
namespace {

struct Numbers {
  double real = 1;
  int whole = 1;
  std::size_t size = 1;
};

/// Returns the message about the options, or "no error".
std::string message_about(const std::string& options) {
  Numbers numbers;
  CommandLine line;
  line.number("--real", numbers.real, 0.1, 1e6, "");
  line.number("--whole", numbers.whole, -5, 1000000, "");
  line.number("--size", numbers.size, 2, 9, "");
  return message_of<UsageError>([&] { line.parse(options); });
}

}  // namespace

TEST_CASE("a number outside its range is refused with the range in plain digits") {
  CHECK(message_about("--real 0") == "--real: Value 0 not in range 0.1 to 1000000");
  CHECK(message_about("--real 1x") == "--real: Value 1x not in range 0.1 to 1000000");
  CHECK(message_about("--real nan") == "--real: Value nan not in range 0.1 to 1000000");
  CHECK(message_about("--whole=-6") == "--whole: Value -6 not in range -5 to 1000000");
  CHECK(message_about("--size=-1") == "--size: Value -1 not in range 2 to 9");
  CHECK(message_about("--real 0.1 --whole=-5 --size 9") == "no error");
}

TEST_CASE("an option needs another one, and a value of its environment variable does not") {
  const auto message = [](const std::string& words) {
    CommandLine line;
    std::string address;
    bool farm = false;
    Option on_farm = line.flag("--farm", farm, "");
    Option option = line.option("--address", address, "");
    option.environment("PATH").needs(on_farm);
    const std::string text = message_of<UsageError>([&] { line.parse(words); });
    return text == "no error" && address.empty() ? std::string("no value") : text;
  };
  CHECK(message("--address a") == "--address requires --farm");
  CHECK(message("--address a --farm") == "no error");
  CHECK(message("") == "no error");
}

TEST_CASE("options that exclude each other are refused together, in either order") {
  const auto message = [](std::vector<const char*> words) {
    CommandLine line("", "program");
    std::string name;
    std::string removed;
    const Option first = line.option("--name", name, "");
    line.option("--remove", removed, "").excludes(first);
    words.insert(words.begin(), "program");
    return message_of<UsageError>(
        [&] { line.parse(static_cast<int>(words.size()), words.data()); });
  };
  const std::string refusal = " exclude each other: leave one of them out; see `program --help`";
  CHECK(message({"--name", "a", "--remove", "b"}) == "--name and --remove" + refusal);
  CHECK(message({"--remove", "b", "--name", "a"}) == "--name and --remove" + refusal);
  CHECK(message({"--name", "a"}) == "no error");
  CHECK(message({"--remove", "b"}) == "no error");
}

TEST_CASE("an option that needs an argument is refused without it, and its help names it") {
  std::string scene;
  bool all = false;
  CommandLine line;
  const Option argument = line.option("SCENE", scene, "");
  line.flag("--all", all, "Trace all").needs(argument);
  CHECK(message_of<UsageError>([&] { line.parse("--all"); }) == "--all requires SCENE");
  CHECK(line.help().find("(with SCENE)") != std::string::npos);
}

}  // namespace parray::test
