#include "common/base/aligned_array.h"

#include <sys/mman.h>

#include <cstdlib>
#include <new>

namespace parray::base {

void* allocate_aligned(std::size_t bytes) {
  constexpr std::size_t line = 64;
  constexpr std::size_t large_page = std::size_t{2} << 20;
  const std::size_t alignment = bytes >= large_page ? large_page : line;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded);
  if (memory == nullptr) throw std::bad_alloc();
  if (alignment == large_page) {
    madvise(memory, rounded, MADV_HUGEPAGE);  // only a hint: the system may ignore it
  }
  return memory;
}

void free_aligned(void* memory) noexcept { std::free(memory); }

}  // namespace parray::base
