#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// A hash that finds a string_view without a copy.
struct NameHash : std::hash<std::string_view> {
  using is_transparent = void;  // NOLINT(readability-identifier-naming): the library's name
};
/// A map from names to their places in a list of names.
using NumbersByName = std::unordered_map<std::string, std::uint32_t, NameHash, std::equal_to<>>;

/// Builds a NameColumn, which stores each name once.
class NameIndex {
 public:
  static constexpr std::size_t max_bytes = 256;

  /// Appends a particle with this name. Throws InputError at `place` if the name has more than
  /// max_bytes bytes.
  void add(std::string_view name, const FilePlace& place);
  /// Returns the place of a name in column().names. Adds unknown names there.
  std::uint32_t number_of(std::string_view name);
  /// Renames a particle, which is counted from 0.
  void rename(std::size_t particle, std::string_view name) {
    column_.index[particle] = number_of(name);
  }

  /// Removes names that no particle uses any more.
  void drop_unused();

  [[nodiscard]] const NameColumn& column() const { return column_; }
  /// Returns whether all names are empty, as in a file without names.
  [[nodiscard]] bool unnamed() const {
    return column_.names.empty() || (column_.names.size() == 1 && column_.names[0].empty());
  }
  /// Returns the column. Returns an empty column if it is unnamed().
  NameColumn finish();

 private:
  NameColumn column_;
  NumbersByName numbers_;
};

/// How a file stores colours.
enum class ColorScale : std::uint8_t {
  linear,  ///< linear RGB, 0 to 1
  srgb8,   ///< 8-bit sRGB, whole numbers 0 to 255
  either   ///< one of the two for the whole file: srgb8 if any component is above 1
};

/// Builds the columns of a file, particle by particle, and checks the values. Reports all errors at
/// `place`. Call position() first for each particle, then the other columns, which must be the same
/// for every particle.
class ParticleColumns {
 public:
  static constexpr std::size_t max_types = std::size_t{1} << 16;  ///< distinct types of a file
  static constexpr std::size_t max_type_bytes = 256;              ///< of the name of a type

  /// `place` is the position of the reader and must outlive this object.
  explicit ParticleColumns(const FilePlace& place) : place_(&place) {}

  /// Sets the number of particles for which columns reserve memory. Call it only if the file can
  /// contain so many.
  void expect(std::uint64_t count) { expected_ = static_cast<std::size_t>(count); }

  void position(const Vec3d& position);
  /// Adds `count` particles at once. `write(particles, first)` writes their positions, radii and
  /// colours (if any) and all numbers into the columns from `first` on. It returns false for an
  /// invalid value. Then rows() adds no particle and returns false. `write` checks the values, and
  /// the caller reports the error.
  bool rows(std::size_t count, bool have_radii, bool have_colors, const auto& write) {
    const std::size_t first = this->count();
    resize(first + count, have_radii, have_colors);
    if (write(particles_, first)) return true;
    resize(first, have_radii, have_colors);
    return false;
  }
  void radius(double radius);
  void color(const Vec3d& color, ColorScale scale);
  void element(std::uint8_t atomic_number);
  /// Adds an unknown element, because the file's text is no element. A note counts such particles
  /// if another element is known.
  void unknown_element();
  void type(std::string_view name);
  /// Begins a numeric column, before the first particle. Returns its place among the numeric
  /// columns. An empty unit is unknown.
  std::size_t add_numbers(std::string name, std::string unit = {});
  /// Adds a number. NaN: not known.
  void number(std::size_t column, double value) {
    particles_.numbers[column].values.push_back(value);
  }

  [[nodiscard]] std::size_t count() const { return particles_.count(); }

  /// Returns the columns. Throws InputError if there is no particle. Removes the column of elements
  /// if no element is known, because its texts are not elements. Removes numeric columns without
  /// any number, because their values are texts.
  Particles finish();
  /// Does the same for a frame, which may have no particles.
  Particles finish_frame();

 private:
  void check_position(const Vec3d& position) const;
  void check_scale(const Vec3d& color);
  void resize(std::size_t count, bool have_radii, bool have_colors);

  const FilePlace* place_;
  Particles particles_;
  std::size_t expected_ = 0;
  bool any_element_ = false;
  std::uint64_t unknown_elements_ = 0;  // of the current frame
  NumbersByName type_index_;
  std::optional<std::uint64_t> above_one_;  // place of the first colour component above 1 (scale
                                            // `either`); below: of the first fraction
  std::optional<std::uint64_t> fraction_;
};

}  // namespace parray::input
