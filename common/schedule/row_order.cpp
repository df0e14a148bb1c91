#include "common/schedule/row_order.h"

#include <bit>
#include <numeric>

namespace parray::schedule {
namespace {

std::uint32_t reverse_bits(std::uint32_t value, int bits) {
  std::uint32_t result = 0;
  for (int b = 0; b < bits; ++b) result = result << 1 | (value >> b & 1U);
  return result;
}

}  // namespace

std::vector<std::uint32_t> make_row_order(RowOrder order, std::uint32_t height) {
  std::vector<std::uint32_t> rows;
  rows.reserve(height);
  if (order != RowOrder::interleaved) {
    rows.resize(height);
    std::iota(rows.begin(), rows.end(), 0U);
    return rows;
  }
  const int bits = height > 1 ? static_cast<int>(std::bit_width(height - 1)) : 0;
  for (std::uint32_t i = 0; i < 1ULL << bits; ++i) {
    const std::uint32_t row = reverse_bits(i, bits);
    if (row < height) rows.push_back(row);
  }
  return rows;
}

}  // namespace parray::schedule
