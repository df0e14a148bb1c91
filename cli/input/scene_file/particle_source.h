#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "cli/input/color/particle_coloring.h"
#include "cli/input/particles/alternatives.h"
#include "cli/input/particles/frame_choice.h"
#include "cli/input/scene_file/json_value.h"
#include "cli/input/select/particle_filter.h"

namespace parray::input {

/// Where the surface of each particle comes from.
struct ParticleMaterial {
  enum class Rule : std::uint8_t {
    automatic,   ///< the first of column, by_element, by_type that the file supports
    named,       ///< one of the scene's materials for all
    by_element,  ///< diffuse, of the element's colour
    by_type,     ///< the scene's material of the type's name, or else a colour for each type
    column,      ///< diffuse, of the file's colour
    painted      ///< in the colour that `color_by` gives it
  };
  Rule rule = Rule::automatic;
  /// Of a material, where the rule is `named`; where it is `painted`, of the one whose kind the
  /// surface has, or empty for diffuse.
  std::string name;
};

/// Where the radius of each particle comes from.
struct ParticleRadius {
  enum class Rule : std::uint8_t {
    automatic,   ///< the first of column, by_element that the file supports
    fixed,       ///< one for all
    by_element,  ///< the element's van der Waals radius
    column       ///< the file's radius
  };
  Rule rule = Rule::automatic;
  double value = 0;  ///< where the rule is `fixed`; in ranges::length
};

/// An item of the scene's section `particles`: a file whose particles become spheres.
struct ParticleSource {
  std::string file;  ///< relative to the folder of the scene file, or absolute
  ParticleMaterial material;
  ParticleRadius radius;
  std::string topology{};  ///< file of names and elements, found as `file` is; empty: none
  AlternativeChoice alternatives{};    ///< of the locations of atoms
  std::optional<FrameChoice> frame{};  ///< of a file that has several; not given: the first
  ParticleFilter filter{};             ///< what of it is shown
  ParticleColoring coloring{};         ///< what its colours mean
  std::uint64_t line = 0;              ///< of the item in the scene file
  std::uint64_t file_line = 0;         ///< of its member `file`
  std::map<std::string, std::uint64_t, std::less<>> lines{};  ///< of its other members, by key

  /// Of the member `key`; that of the item where it is not given.
  [[nodiscard]] std::uint64_t line_of(std::string_view key) const {
    const auto found = lines.find(key);
    return found == lines.end() ? line : found->second;
  }
};

inline constexpr std::array<std::string_view, 3> particle_material_words{"by-element", "by-type",
                                                                         "column"};
inline constexpr std::array<std::string_view, 2> particle_radius_words{"by-element", "column"};

/// One of particle_material_words or, for any other text, the material of that name.
ParticleMaterial particle_material_from(std::string_view text);
/// One of particle_radius_words; nothing for any other text.
std::optional<ParticleRadius> particle_radius_from(std::string_view text);

/// The word, or the material's name, that is read as this; empty for `automatic`, and for `painted`
/// without a name.
std::string text_of(const ParticleMaterial& material);
/// The word that is read as this; empty for `automatic` and `fixed`.
std::string text_of(const ParticleRadius& radius);

/// Throws InputError that names the place and the line in the scene file.
ParticleSource read_particle_source(const JsonValue& value, const JsonPlace& place);

}  // namespace parray::input
