#pragma once

#include <cstddef>
#include <memory>
#include <span>
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

/// Allocates zeroed memory directly from the system, which clears a page only when it is touched.
/// If `large_pages`, asks for large pages for 4 MiB or more. Large pages are faster unless few
/// elements are touched. Returns null for 0 bytes. Throws std::bad_alloc if the system has too
/// little memory.
void* allocate_zeroed(std::size_t bytes, bool large_pages = true);
/// Frees memory of allocate_zeroed(). `bytes` must be the same.
void free_zeroed(void* memory, std::size_t bytes) noexcept;

/// A fixed number of plain elements that begin with all bits zero. It is meant for arrays with an
/// element per pixel: clearing them first would cost as much as filling them.
template <typename T>
class ZeroedArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  explicit ZeroedArray(std::size_t size, bool large_pages = true)
      : memory_(static_cast<T*>(allocate_zeroed(size * sizeof(T), large_pages)),
                Free{size * sizeof(T)}),
        size_(size) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T& operator[](std::size_t i) { return memory_.get()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return memory_.get()[i]; }
  [[nodiscard]] std::span<const T> view() const { return {memory_.get(), size_}; }

 private:
  struct Free {
    std::size_t bytes;
    void operator()(T* memory) const noexcept { free_zeroed(memory, bytes); }
  };
  std::unique_ptr<T[], Free> memory_;
  std::size_t size_;
};

}  // namespace parray::base
