#include <doctest/doctest.h>

#include <limits>

#include "cli/output/picture/image_file.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

constexpr std::uint64_t huge = std::numeric_limits<std::uint64_t>::max();

MetadataValue kept(const MetadataValue& value, bool exr) {
  return as_kept({{"a", value}}, exr).at(0).second;
}

std::optional<std::uint64_t> whole(const MetadataValue& value) {
  return whole_in({{"a", value}}, "a");
}

}  // namespace

TEST_CASE("EXR stores numbers in its numeric types, PNG stores text") {
  CHECK_UNARY(kept(std::uint64_t{0x7FFFFFFF}, true) == MetadataValue(std::uint64_t{0x7FFFFFFF}));
  CHECK_UNARY(kept(std::uint64_t{0x80000000}, true) == MetadataValue(2147483648.0));
  CHECK_UNARY(kept(huge, true) == MetadataValue("18446744073709551615"));
  CHECK_UNARY(kept(0.1, true) == MetadataValue(0.1));
  CHECK_UNARY(kept("word", true) == MetadataValue("word"));
  CHECK_UNARY(kept(std::uint64_t{7}, false) == MetadataValue("7"));
  CHECK_UNARY(kept(0.1, false) == MetadataValue("0.1"));
}

TEST_CASE("a number reads back equal from any form in a file") {
  for (const bool exr : {true, false}) {
    for (const std::uint64_t n : {std::uint64_t{0}, std::uint64_t{1} << 31, std::uint64_t{1} << 53,
                                  (std::uint64_t{1} << 53) + 1, huge}) {
      CHECK(whole(kept(n, exr)) == n);
    }
    for (const double x : {0.0, 0.1, 1e-300, 12345.678}) {
      CHECK(real_in({{"a", kept(x, exr)}}, "a") == x);
    }
  }
}

TEST_CASE("values of another kind are not returned") {
  for (const char* text : {"", "-1", "1.5", "12x", " 1", "18446744073709551616"}) {
    CHECK(whole(text) == std::nullopt);
  }
  for (const double real : {-1.0, 1.5, 1e300, std::numeric_limits<double>::quiet_NaN()}) {
    CHECK(whole(real) == std::nullopt);
  }
  CHECK(real_in({{"a", "one"}}, "a") == std::nullopt);
  CHECK(text_in({{"a", 1.0}}, "a") == std::nullopt);
  CHECK(text_in({{"a", "b"}}, "A") == std::nullopt);
}

}  // namespace parray
