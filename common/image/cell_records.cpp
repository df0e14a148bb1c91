#include "common/image/cell_records.h"

#include <xxhash.h>

#include <algorithm>
#include <cstring>

namespace parray::image {

std::uint64_t cell_digest(std::span<const std::byte> record) {
  // The header holds the digest of the sums. Seeding with it would be slower: XXH3 makes a table
  // for each seed.
  const auto sums = record.subspan(sizeof(CellHeader));
  CellHeader header = header_of(record);
  header.nanoseconds = XXH3_64bits(sums.data(), sums.size());
  return std::max<std::uint64_t>(XXH3_64bits(&header, sizeof header), 1);
}

std::vector<std::uint64_t> cell_digests(std::span<const std::byte> records,
                                        std::size_t record_bytes) {
  std::vector<std::uint64_t> digests;
  digests.reserve(records.size() / record_bytes);
  for (; !records.empty(); records = records.subspan(record_bytes)) {
    digests.push_back(cell_digest(records.first(record_bytes)));
  }
  return digests;
}

std::uint64_t range_digest(std::span<const std::uint64_t> cell_digests) {
  return XXH3_64bits(cell_digests.data(), cell_digests.size_bytes());
}

CellHeader header_of(std::span<const std::byte> record) {
  CellHeader header;
  std::memcpy(&header, record.data(), sizeof header);
  return header;
}

void copy_sums(std::span<const std::byte> record, std::span<PixelSums> sums) {
  std::memcpy(sums.data(), record.data() + sizeof(CellHeader), sums.size_bytes());
}

}  // namespace parray::image
