#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <utility>

#include "common/rooms.h"

namespace parray::base {

/// Allocates uninitialised memory of `bytes` bytes, aligned to a cache line (64 bytes). Asks the
/// system for large pages from 2 MiB on. Throws std::bad_alloc. free_aligned() releases the memory.
void* allocate_aligned(std::size_t bytes);
void free_aligned(void* memory) noexcept;

/// A fixed number of plain elements, aligned to a cache line and not initialised.
template <typename T>
class AlignedArray {
  static_assert(std::is_trivially_destructible_v<T>);

 public:
  AlignedArray() = default;
  explicit AlignedArray(std::size_t size)
      : memory_(static_cast<T*>(allocate_aligned(size * sizeof(T)))), size_(size) {}
  /// A move leaves `other` empty.
  AlignedArray(AlignedArray&& other) noexcept
      : memory_(std::move(other.memory_)), size_(std::exchange(other.size_, 0)) {}
  AlignedArray& operator=(AlignedArray&& other) noexcept {
    memory_ = std::move(other.memory_);
    size_ = std::exchange(other.size_, 0);
    return *this;
  }
  ~AlignedArray() = default;

  [[nodiscard]] T* data() { return memory_.get(); }
  [[nodiscard]] const T* data() const { return memory_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] std::size_t bytes() const { return size_ * sizeof(T); }
  [[nodiscard]] T& operator[](std::size_t i) { return memory_.get()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return memory_.get()[i]; }

 private:
  struct Free {
    void operator()(T* memory) const noexcept { free_aligned(memory); }
  };
  std::unique_ptr<T[], Free> memory_;
  std::size_t size_ = 0;
};

}  // namespace parray::base
