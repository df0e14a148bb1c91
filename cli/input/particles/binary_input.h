#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "cli/input/particles/particle_input.h"

namespace parray::input {

/// The number in the bytes at `from`; `swapped`: they are in the other order than this machine's.
template <typename T>
T binary_value(const char* from, bool swapped) {
  std::array<char, sizeof(T)> own{};
  std::memcpy(own.data(), from, sizeof(T));
  if (swapped) std::reverse(own.begin(), own.end());
  return std::bit_cast<T>(own);
}

/// `bytes` and those that fill the last unit of four, as XDR and netCDF write them.
constexpr std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }

/// A file of particles as numbers in one byte order, read once from front to back.
class BinaryInput {
 public:
  /// `file` must outlive this.
  explicit BinaryInput(PackedFile& file, std::endian order = std::endian::big)
      : input_(file), swapped_(order != std::endian::native) {}

  void set_order(std::endian order) { swapped_ = order != std::endian::native; }

  /// The next number; fails when the file ends before.
  template <typename T>
  T get() {
    return binary_value<T>(bytes(sizeof(T)).data(), swapped_);
  }
  /// Calls `put(value)` with the next `count` numbers.
  template <typename T, typename Put>
  void each(std::uint64_t count, const Put& put) {
    constexpr std::uint64_t at_once = ParticleInput::max_bytes_at_once / sizeof(T);
    while (count > 0) {
      const auto part = static_cast<std::size_t>(std::min(count, at_once));
      const char* const from = bytes(part * sizeof(T)).data();
      for (std::size_t i = 0; i < part; ++i) {
        put(binary_value<T>(from + i * sizeof(T), swapped_));
      }
      count -= part;
    }
  }
  /// The next `count` bytes, at most ParticleInput::max_bytes_at_once; valid until the next call.
  std::string_view bytes(std::size_t count) {
    const char* const from = input_.next_bytes(count);
    if (from == nullptr) fail_end();
    return {from, count};
  }
  void skip(std::uint64_t count) {
    if (!input_.skip_bytes(count)) fail_end();
  }

  /// Whether the file ends here.
  bool at_end() { return input_.peek_bytes(1) == nullptr; }
  /// Fails when the file cannot have so many more bytes.
  void expect(std::uint64_t count) const {
    if (input_.bytes_left().value_or(count) < count) fail_end();
  }
  /// Bytes taken so far.
  [[nodiscard]] std::uint64_t position() const { return input_.position(); }
  [[nodiscard]] const FilePlace& place() const { return input_.place(); }
  [[noreturn]] void fail(std::string_view problem) const { input_.fail(problem); }

 private:
  [[noreturn]] void fail_end() const { fail("the file ends within its data: is it complete?"); }

  ParticleInput input_;
  bool swapped_;
};

}  // namespace parray::input
