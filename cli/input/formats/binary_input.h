#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particle_columns.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/particles.h"
#include "common/scene/limits.h"

namespace parray::input {

/// Returns the number in the bytes at `from`. `swapped`: the bytes have the opposite order of this
/// machine.
template <typename T>
T binary_value(const char* from, bool swapped) {
  std::array<char, sizeof(T)> own{};
  std::memcpy(own.data(), from, sizeof(T));
  if (swapped) std::ranges::reverse(own);
  return std::bit_cast<T>(own);
}

/// Returns `bytes` rounded up to a multiple of four. XDR and netCDF pad data so.
constexpr std::uint64_t padded(std::uint64_t bytes) { return (bytes + 3) / 4 * 4; }

/// Reads a particle file as big-endian numbers, once from front to back. Members that read throw
/// InputError if the file ends early.
class BinaryInput {
 public:
  /// `file` must outlive this object.
  explicit BinaryInput(PackedFile& file) : input_(file) {}

  /// Reads the following numbers in the byte order of this machine.
  void use_native_order() { swapped_ = false; }

  /// Returns the next number.
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
      for (std::size_t i = 0; i < part; ++i) put(binary_value<T>(from + i * sizeof(T), swapped_));
      count -= part;
    }
  }
  /// Returns the next `count` bytes, at most ParticleInput::max_bytes_at_once. Valid until the next
  /// call.
  std::string_view bytes(std::size_t count) {
    const char* const from = input_.next_bytes(count);
    if (from == nullptr) fail_end();
    return {from, count};
  }
  void skip(std::uint64_t count) {
    if (!input_.skip_bytes(count)) fail_end();
  }

  /// Returns whether the file ends here.
  bool at_end() { return input_.peek_bytes(1) == nullptr; }
  /// Fails if fewer than `count` bytes remain. Does nothing for packed files, because their size is
  /// unknown.
  void expect(std::uint64_t count) const {
    if (input_.bytes_left().value_or(count) < count) fail_end();
  }
  /// Returns the number of bytes read so far.
  [[nodiscard]] std::uint64_t position() const { return input_.position(); }
  [[nodiscard]] const FilePlace& place() const { return input_.place(); }
  [[noreturn]] void fail(std::string_view problem) const { input_.fail(problem); }
  [[noreturn]] void fail_damaged(std::string_view problem) const { place().fail_damaged(problem); }

 private:
  [[noreturn]] void fail_end() const { place().fail_incomplete("the file ends within its data"); }

  ParticleInput input_;
  bool swapped_ = std::endian::native != std::endian::big;
};

/// Returns `count`. Throws InputError at `place` if it is negative or above limits::max_shapes.
inline std::uint64_t checked_atoms(std::int64_t count, const FilePlace& place) {
  if (count < 0 || static_cast<std::uint64_t>(count) > limits::max_shapes) {
    place.fail(std::to_string(count) +
               " atoms: the file is probably damaged, copy it again (the limit is " +
               std::to_string(limits::max_shapes) + " atoms)");
  }
  return static_cast<std::uint64_t>(count);
}

/// Returns a frame with these positions and no other column. Throws InputError at `place` for
/// positions out of range.
inline Particles frame_of(const std::vector<Vec3d>& positions, const FilePlace& place) {
  ParticleColumns columns(place);
  columns.expect(positions.size());
  for (const Vec3d& position : positions) columns.position(position);
  return columns.finish_frame();
}

}  // namespace parray::input
