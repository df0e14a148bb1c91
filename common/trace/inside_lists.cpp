#include "common/trace/inside_lists.h"

#include <cstdlib>
#include <new>

namespace parray::trace {

InsideLists::~InsideLists() { std::free(links_); }

void InsideLists::grow() {
  const std::uint32_t capacity = capacity_ == 0 ? 1024 : 2 * capacity_;
  void* links = std::realloc(links_, std::size_t{capacity} * sizeof(Link));
  if (links == nullptr) throw std::bad_alloc();
  links_ = static_cast<Link*>(links);
  capacity_ = capacity;
}

}  // namespace parray::trace
