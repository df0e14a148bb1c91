#include "common/image/cell_records.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include "tests/support/dice.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Dice;

std::vector<std::byte> random_records(Dice& dice, std::size_t bytes) {
  std::vector<std::byte> records(bytes);
  for (std::byte& byte : records) byte = static_cast<std::byte>(dice.below(256));
  return records;
}

bool in_time(std::size_t byte_of_record) {
  constexpr std::size_t time = offsetof(CellHeader, nanoseconds);
  return byte_of_record >= time && byte_of_record < time + sizeof(std::uint64_t);
}

}  // namespace

TEST_CASE("one changed bit anywhere but in the time changes the digest of that cell alone") {
  Dice dice(3);
  const std::size_t record_bytes = image::record_bytes(5);
  auto records = random_records(dice, 3 * record_bytes);
  const auto before = cell_digests(records, record_bytes);
  REQUIRE(before.size() == 3);
  for (std::size_t byte = 0; byte < records.size(); ++byte) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      records[byte] ^= static_cast<std::byte>(1U << bit);
      const auto after = cell_digests(records, record_bytes);
      records[byte] ^= static_cast<std::byte>(1U << bit);
      for (std::size_t cell = 0; cell < 3; ++cell) {
        const bool touched = byte / record_bytes == cell && !in_time(byte % record_bytes);
        CHECK_UNARY((after[cell] != before[cell]) == touched);
      }
      CHECK_UNARY((range_digest(after) != range_digest(before)) == !in_time(byte % record_bytes));
    }
  }
}

TEST_CASE("no record has digest 0, and the digest of a range knows their order and number") {
  const std::vector<std::byte> zeros(4 * 72);
  for (const std::uint64_t digest : cell_digests(zeros, 72)) CHECK(digest != 0);
  const std::vector<std::uint64_t> some = {1, 2, 3};
  CHECK(range_digest(some) != range_digest(std::vector<std::uint64_t>{1, 3, 2}));
  CHECK(range_digest(some) != range_digest(std::vector<std::uint64_t>{1, 2}));
  CHECK(cell_digests({}, 72).empty());
}

}  // namespace parray
