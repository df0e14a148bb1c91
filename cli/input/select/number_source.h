#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Numbers that particles have beside the file's numeric columns: x, y, z; fx, fy, fz, which are
/// fractions of the cell along its edges a, b, c, or of the box around all centres where the file
/// has no cell; radius; index, from 0; resid, the residue's number.
std::span<const std::string_view> number_words();

/// True for a numeric column, which a reader must be asked for.
bool is_number_column(std::string_view name);

/// A number that each particle has. Refers to the particles, which must outlive it.
class NumberSource {
 public:
  /// Nothing when these particles have no such number.
  static std::optional<NumberSource> of(std::string_view name, const Particles& particles);

  /// Writes the numbers of the particles from `begin` on, `out.size()` of them; NaN: not known.
  void values(std::size_t begin, std::span<double> out) const;

 private:
  enum class Kind : unsigned char { component, fraction, radius, index, residue, column };

  const Particles* particles_ = nullptr;
  Kind kind_ = Kind::component;
  std::size_t axis_ = 0;
  Vec3d origin_{};  // of fractions: dot(position - origin, slope)
  Vec3d slope_{};
  const std::vector<double>* column_ = nullptr;
};

/// The names that of() knows, for messages.
std::vector<std::string> number_names(const Particles& particles);

}  // namespace parray::input
