#include "common/base/zeroed_array.h"

#include <sys/mman.h>

#include <new>

namespace parray::base {

void* allocate_zeroed(std::size_t bytes, bool large_pages) {
  constexpr std::size_t large_page = std::size_t{2} << 20;
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
