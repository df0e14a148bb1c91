#include "common/base/arrays.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <utility>

#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("a moved array leaves an empty one") {
  AlignedArray<std::uint32_t> first(10);
  first[9] = 7;
  AlignedArray<std::uint32_t> second(std::move(first));
  // NOLINTBEGIN(bugprone-use-after-move): the moved array must be empty
  CHECK(first.size() == 0);
  CHECK(first.bytes() == 0);
  CHECK(first.data() == nullptr);
  first = std::move(second);
  CHECK(second.size() == 0);
  CHECK(second.data() == nullptr);
  // NOLINTEND(bugprone-use-after-move)
  CHECK(first.size() == 10);
  CHECK(first[9] == 7);
}

}  // namespace parray
