#include "common/base/huge_pages.h"

#include <sys/mman.h>

#include <cstdint>

namespace parray {

void wish_huge_pages(void* data, std::size_t bytes) {
  constexpr std::size_t huge = std::size_t{1} << 21;
  if (bytes < 2 * huge) return;
  const std::size_t skipped = -reinterpret_cast<std::uintptr_t>(data) & (huge - 1);
  madvise(static_cast<char*>(data) + skipped, (bytes - skipped) / huge * huge, MADV_HUGEPAGE);
}

}  // namespace parray
