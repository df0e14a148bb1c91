#pragma once

#include <cstdint>

#include "common/math/inline.h"
#include "common/trace/ray.h"

namespace parray::trace {

/// Stores, for each path of a batch, the list of the shapes that the path is inside of. Each list
/// is a chain of links in one pool. A path holds the number of its first link; `none`: the list is
/// empty. Serves one batch at a time; not thread-safe.
class InsideLists {
 public:
  static constexpr std::uint32_t none = no_shape;

  ~InsideLists();
  InsideLists& operator=(InsideLists&&) = delete;

  /// Empties all lists.
  PARRAY_INLINE void clear() {
    used_ = 0;
    free_ = none;
  }
  PARRAY_INLINE std::uint32_t shape(std::uint32_t link) const { return links_[link].shape; }
  /// Returns the link after `link`; `none` after the last one.
  PARRAY_INLINE std::uint32_t next(std::uint32_t link) const { return links_[link].next; }
  /// Returns next() for each lane of a vector of links. No lane may be `none`; a lane that does not
  /// matter may be 0. push() must have been called at least once, also if clear() came after it.
  template <typename Uint>
  PARRAY_INLINE Uint next(const Uint& link) const {
    static_assert(sizeof(Link) == 2 * sizeof(std::uint32_t));
    return Uint::gather(&links_->next, link << 1);
  }

  /// Returns the list `head` with a shape in front of it. Throws std::bad_alloc.
  PARRAY_INLINE std::uint32_t push(std::uint32_t head, std::uint32_t shape) {
    std::uint32_t link = free_;
    if (link != none) {
      free_ = links_[link].next;
    } else {
      if (used_ == capacity_) grow();
      link = used_++;
    }
    links_[link] = {shape, head};
    return link;
  }
  /// Returns the list `head` without `shape`, which must be in it.
  PARRAY_INLINE std::uint32_t remove(std::uint32_t head, std::uint32_t shape) {
    std::uint32_t* to = &head;
    while (links_[*to].shape != shape) to = &links_[*to].next;
    const std::uint32_t link = *to;
    *to = links_[link].next;
    links_[link].next = free_;
    free_ = link;
    return head;
  }
  /// Frees all links of the list `head` of a path that has ended. `head` may be `none`.
  PARRAY_INLINE void release(std::uint32_t head) {
    while (head != none) {
      const std::uint32_t after = links_[head].next;
      links_[head].next = free_;
      free_ = head;
      head = after;
    }
  }

 private:
  struct Link {
    std::uint32_t shape;
    std::uint32_t next;
  };
  /// Throws std::bad_alloc.
  void grow();

  Link* links_ = nullptr;
  std::uint32_t used_ = 0;
  std::uint32_t capacity_ = 0;
  std::uint32_t free_ = none;
};

}  // namespace parray::trace
