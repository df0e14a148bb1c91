// Seeds and old finds, through the functions that libFuzzer calls: with any compiler, in any build.
#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/fuzz/target.h"
#include "tests/support/rooms.h"

namespace parray::fuzz {
namespace {

namespace fs = std::filesystem;

/// Files that have been findings once, in the order of their names.
std::vector<fs::path> finds_of(const Target& target) {
  std::vector<fs::path> files;
  const fs::path directory = fs::path(PARRAY_SOURCE_DIR "/tests/fuzz/finds") / target.name;
  if (fs::exists(directory)) {
    std::ranges::copy(fs::directory_iterator(directory), std::back_inserter(files));
  }
  std::ranges::sort(files);
  return files;
}

std::string bytes_of(const fs::path& file) {
  std::ostringstream bytes;
  bytes << std::ifstream(file, std::ios::binary).rdbuf();
  return bytes.str();
}

}  // namespace

TEST_CASE("what the fuzzers begin with is taken, and keeps every promise") {
  for (const Target* target : targets()) {
    CAPTURE(target->name);
    const std::vector<std::string> seeds = target->seeds();
    CHECK(seeds.size() >= 3);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      CAPTURE(i);
      CHECK_NOTHROW(CHECK(target->run(seeds[i])));
    }
  }
}

TEST_CASE("what the fuzzers have found stays mended") {
  std::size_t finds = 0;
  for (const Target* target : targets()) {
    for (const fs::path& file : finds_of(*target)) {
      CAPTURE(file);
      CHECK_NOTHROW(target->run(bytes_of(file)));
      ++finds;
    }
  }
  CHECK(finds > 0);
}

TEST_CASE("every beginning of a seed, none included, keeps every promise") {
  for (const Target* target : targets()) {
    CAPTURE(target->name);
    for (const std::string& seed : target->seeds()) {
      const std::size_t step = std::max<std::size_t>(seed.size() / 50, 1);
      for (std::size_t size = 0; size < seed.size(); size += step) {
        CAPTURE(size);
        CHECK_NOTHROW(target->run(std::string_view(seed).substr(0, size)));
      }
    }
  }
}

TEST_CASE("a broken promise is a violation, and an unknown target an error") {
  CHECK_NOTHROW(promise(true, "kept"));
  CHECK_THROWS_WITH_AS(promise(false, "not kept"), "not kept", Violation);
  CHECK_THROWS_AS(promise_one_line("two\nlines"), Violation);
  CHECK_THROWS_AS(promise_one_line(""), Violation);
  CHECK_THROWS_AS(static_cast<void>(target_named("none")), std::invalid_argument);
}

}  // namespace parray::fuzz
