#include "cli/output/input_files.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <string>

#include "cli/output/picture/partial_file.h"
#include "common/base/error.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

namespace parray::test {
namespace {

namespace fs = std::filesystem;

TEST_CASE("an input file is no output under any of its names, and other files are outputs") {
  const TemporaryDirectory directory;
  const fs::path& folder = directory.path();
  picture::write_text_file(folder / "input", "a");
  picture::write_text_file(folder / "other", "b");
  fs::create_symlink("input", folder / "link");
  fs::create_hard_link(folder / "input", folder / "second");
  const output::InputFiles inputs{folder / "link", folder / "missing", ""};
  for (const char* const name : {"input", "link", "second", "missing", "./input"}) {
    CAPTURE(name);
    const std::string says =
        (folder / name).string() + " is an input file: name another output file";
    CHECK_THROWS_WITH_AS(inputs.check(folder / name), says.c_str(), InputError);
  }
  CHECK_NOTHROW(inputs.check(folder / "other"));
  CHECK_NOTHROW(inputs.check(folder / "new"));
  CHECK_NOTHROW(inputs.check(""));
}

}  // namespace
}  // namespace parray::test
