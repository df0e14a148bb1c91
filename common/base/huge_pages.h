#pragma once

#include <cstddef>
#include <vector>

namespace parray {

/// Asks the system for huge pages where these bytes are, before they are first touched. A wish:
/// nothing is lost where it is not granted.
void wish_huge_pages(void* data, std::size_t bytes);

/// vector.reserve(), on huge pages where that is much.
template <typename T>
void reserve_large(std::vector<T>& vector, std::size_t count) {
  if (count <= vector.capacity()) return;
  vector.reserve(count);
  T* const unused = vector.data() + vector.size();
  wish_huge_pages(unused, (vector.capacity() - vector.size()) * sizeof(T));
}

}  // namespace parray
