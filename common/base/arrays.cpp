#include "common/base/arrays.h"

#include <sys/mman.h>

#include <cstdlib>
#include <new>

namespace parray::base {

static constexpr std::size_t large_page = std::size_t{2} << 20;

void* allocate_aligned(std::size_t bytes) {
  constexpr std::size_t line = 64;
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

void* allocate_zeroed(std::size_t bytes, bool large_pages) {
  if (bytes == 0) return nullptr;
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  if (large_pages && bytes >= 2 * large_page) {
    madvise(memory, bytes, MADV_HUGEPAGE);  // only a hint: the system may ignore it
  }
  return memory;
}

void free_zeroed(void* memory, std::size_t bytes) noexcept {
  if (memory != nullptr) munmap(memory, bytes);
}

}  // namespace parray::base
