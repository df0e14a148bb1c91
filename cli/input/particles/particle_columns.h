#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// How a file writes colours.
enum class ColorScale : std::uint8_t {
  linear,  ///< linear RGB, 0 to 1
  srgb8,   ///< 8-bit sRGB, whole numbers 0 to 255
  either   ///< one of them for the whole file: srgb8 as soon as a component is above 1
};

/// Builds the columns of a file, particle by particle, and checks what goes into them: everything
/// fails at `place`. After position() come the other columns of the same particle, the same ones
/// for every particle.
class ParticleColumns {
 public:
  static constexpr std::size_t max_types = std::size_t{1} << 16;
  static constexpr std::size_t max_type_bytes = 256;

  /// `place` is where the reader stands; it must outlive this.
  explicit ParticleColumns(const FilePlace& place) : place_(&place) {}

  /// Room for `count` particles, of which the reader knows that the file can hold them.
  void expect(std::uint64_t count) { expected_ = static_cast<std::size_t>(count); }

  void position(const Vec3d& position);
  /// Adds `count` particles at once: `write(particles, first)` puts their positions, and radii and
  /// colours if they are to have any, into the columns from `first` on, and numbers into all of
  /// theirs. False, and none is added, when it returns false, which it does when one of them would
  /// be refused.
  template <typename Write>
  bool rows(std::size_t count, bool have_radii, bool have_colors, const Write& write) {
    const std::size_t first = this->count();
    resize(first + count, have_radii, have_colors);
    if (write(particles_, first)) return true;
    resize(first, have_radii, have_colors);
    return false;
  }
  /// Another position for a particle that is there.
  void move(std::size_t index, const Vec3d& position);
  void radius(double radius);
  void color(const Vec3d& color, ColorScale scale);
  void element(std::uint8_t atomic_number);
  /// Of a particle whose element the file gives, but in no form that is known. Counted in a note.
  void unknown_element();
  void type(std::string_view name);
  /// Begins a column of numbers, before the first particle; returns its place among them.
  std::size_t add_numbers(std::string name);
  /// NaN: not known.
  void number(std::size_t column, double value) {
    particles_.numbers[column].values.push_back(value);
  }

  [[nodiscard]] std::size_t count() const { return particles_.count(); }

  /// The columns. Fails when there is no particle. A column of elements that knows none is left
  /// out: the names were no elements; one of numbers that knows none, too: they were texts.
  Particles finish();
  /// The same of a frame, which may have no particle.
  Particles finish_frame();

 private:
  void check_position(const Vec3d& position) const;
  void check_scale(const Vec3d& color);
  void resize(std::size_t count, bool have_radii, bool have_colors);

  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;  // NOLINT(readability-identifier-naming): the library's name
  };
  const FilePlace* place_;
  Particles particles_;
  std::size_t expected_ = 0;
  bool any_element_ = false;
  std::uint64_t unknown_elements_ = 0;  // of the frame
  std::unordered_map<std::string, std::uint32_t, Hash, std::equal_to<>> type_index_;
  std::optional<std::uint64_t> above_one_;  // where the first such component of `either` stands
  std::optional<std::uint64_t> fraction_;
};

}  // namespace parray::input
