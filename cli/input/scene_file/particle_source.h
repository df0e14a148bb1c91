#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/color/number_bounds.h"
#include "cli/input/color/particle_coloring.h"
#include "cli/input/particles/arrows.h"
#include "cli/input/particles/bonds.h"
#include "cli/input/particles/cell_operations.h"
#include "cli/input/particles/particles.h"
#include "cli/input/select/particle_filter.h"

namespace parray::input {

/// Where the material of each particle comes from.
struct ParticleMaterial {
  enum class Rule : std::uint8_t {
    automatic,   ///< the first of column, by_element, by_type that the file supports
    named,       ///< one material of the scene for all
    by_element,  ///< diffuse, in the element's colour
    by_type,     ///< the scene's material with the name of the type, otherwise one colour per type
    column,      ///< diffuse, in the colour of the file
    color_by     ///< in the colour that `color_by` assigns
  };
  Rule rule = Rule::automatic;
  /// For `named`: the name of the material. For `color_by`: the name of the material that gives the
  /// kind of surface; empty means diffuse.
  std::string name;

  friend bool operator==(const ParticleMaterial&, const ParticleMaterial&) = default;
};

/// Where the radius of each particle comes from.
struct ParticleRadius {
  enum class Rule : std::uint8_t {
    automatic,   ///< the first of column, by_element (crystals: covalent) that the file supports
    fixed,       ///< one radius for all
    by_element,  ///< the element's van der Waals radius
    covalent,    ///< the element's crystal_radius()
    column       ///< the file's radius
  };
  Rule rule = Rule::automatic;
  double value = 0;  ///< radius if the rule is `fixed`; in ranges::length

  friend bool operator==(const ParticleRadius&, const ParticleRadius&) = default;
};

/// A rule that makes radii from a number of each particle, such as its mass. By default, there is
/// no rule.
struct RadiusScale {
  std::string by;   ///< name of the number; empty: none
  double low = 0;   ///< radius of the least number, in ranges::length; 0: the number is the radius
  double high = 0;  ///< radius of the largest number, above `low`; 0 if `low` is 0
  /// Numbers that get `low` and `high`: those of all frames. Empty: those of the particles. Scene
  /// files do not contain them.
  NumberBounds numbers{};

  [[nodiscard]] bool empty() const { return by.empty(); }
  friend bool operator==(const RadiusScale&, const RadiusScale&) = default;
};

/// The shapes of particles and bonds.
enum class ParticleStyle : std::uint8_t {
  automatic,         ///< balls_and_sticks for small molecules of automatic scenes, else spheres
  spheres,           ///< bonds are not drawn
  balls_and_sticks,  ///< smaller spheres, bonds as sticks
  sticks             ///< spheres as thick as the sticks, so that sticks have round ends
};
/// Words for ParticleStyle, in the order of the enumeration.
inline constexpr std::array<std::string_view, 4> particle_style_words{"auto", "spheres",
                                                                      "balls-and-sticks", "sticks"};
/// Words for BondSource, in the order of the enumeration.
inline constexpr std::array<std::string_view, 3> bond_source_words{"auto", "file", "off"};

/// How particles look.
struct ParticleLook {
  ParticleStyle style = ParticleStyle::automatic;
  ParticleMaterial material{};
  ParticleRadius radius{};
  RadiusScale radius_by{};               ///< replaces `radius`
  std::optional<double> stick_radius{};  ///< in ranges::length; not given: stick_radius_of()
  ParticleColoring coloring{};           ///< what the colours mean

  friend bool operator==(const ParticleLook&, const ParticleLook&) = default;
};

/// A selection of the particles that has its own look.
struct Representation {
  std::string select;      ///< a selection (selection.h); not empty
  ParticleLook look{};     ///< members that are not given have the values of the source's look
  std::uint64_t line = 0;  ///< line of its item in the scene file, from 1; 0: from options

  friend bool operator==(const Representation&, const Representation&) = default;
};

/// Largest number of representations of a file.
inline constexpr std::size_t max_representations = 256;

/// An item of the scene's section `particles`: a file whose particles become spheres, and whose
/// bonds, vectors and cell become capsules.
struct ParticleSource {
  std::string file;  ///< relative to the folder of the scene file, or absolute
  ParticleLook look{};
  std::string topology{};  ///< file with names and elements, relative like `file`; empty: none
  AlternativeChoice alternatives{};    ///< which locations of atoms are read
  std::optional<FrameChoice> frame{};  ///< not given: the first frame with particles
  CellOperations cell{};               ///< copies, wrapping and so on in a periodic cell
  ParticleFilter filter{};             ///< which particles are shown
  BondSource bonds = BondSource::automatic;
  std::string arrows{};                 ///< vectors that arrows show (arrows.h); empty: none
  std::optional<double> arrow_scale{};  ///< length of the arrow of a vector of length 1; not given:
                                        ///< the longest arrow has longest_arrow spacings (arrows.h)
  /// The numbers that set length and width of the arrows in all frames of a film. Not given: those
  /// of the particles. Scene files do not contain it.
  std::optional<ArrowMeasure> arrow_measure{};
  bool solid_cell = false;  ///< the edges of the cell are rods
  /// Of the particles that `filter` shows, only those in one of these representations remain.
  /// Empty: all remain, with `look`.
  std::vector<Representation> shows{};
  std::uint64_t line = 0;  ///< line of the item in the scene file, from 1; 0: from options
  std::map<std::string, std::uint64_t, std::less<>> lines{};  ///< of its members' values, by key

  /// Returns the line of the member `key`. Returns the line of the item if the member is not given.
  [[nodiscard]] std::uint64_t line_of(std::string_view key) const {
    const auto found = lines.find(key);
    return found == lines.end() ? line : found->second;
  }
};

inline constexpr std::array<std::string_view, 3> particle_material_words{"by-element", "by-type",
                                                                         "column"};
inline constexpr std::array<std::string_view, 3> particle_radius_words{"by-element", "covalent",
                                                                       "column"};

/// Returns the look of a representation. Members that `look` does not give have the values of
/// `base`, with these exceptions:
/// - If `look` has a colouring, or a material that sets the colours, it takes from `base` no member
///   of the colouring and no material that sets the colours.
/// - If `look` has `radius` or `radius_by`, it takes neither from `base`.
/// - If its style is `spheres`, it takes no radius of sticks.
ParticleLook completed(ParticleLook look, const ParticleLook& base);

/// A contradiction between the members of a source.
struct SourceProblem : ColoringProblem {
  /// Number of the representation that has it, from 0. Nothing: a member of the source itself.
  std::optional<std::size_t> representation{};
};
/// Returns the first contradiction between the members of `source`; nothing if there is none.
std::optional<SourceProblem> problem_with(const ParticleSource& source);
/// Returns a text about a source with options in place of members in quotes: "--color-by" for
/// "\"color_by\"".
std::string naming_options(std::string text);

/// Parses one of particle_material_words. Any other text is the name of a material. Never throws.
ParticleMaterial particle_material_from(std::string_view text);
/// Parses one of particle_radius_words or a number in ranges::length. Throws InputError, which
/// names no place, for other texts.
ParticleRadius particle_radius_from(std::string_view text);

/// Parses COLUMN or COLUMN:LOW:HIGH. COLUMN may contain a colon: velocity:0. Throws InputError,
/// which names no place, for other texts.
RadiusScale radius_scale_from(std::string_view text);

/// Returns the text that particle_material_from() parses to `material`. Returns "" for `automatic`,
/// and for `color_by` without a name.
std::string text_of(const ParticleMaterial& material);
/// Returns the text that particle_radius_from() parses to `radius`. Returns "" for `automatic`.
std::string text_of(const ParticleRadius& radius);

/// Returns the text that radius_scale_from() parses to `scale`. Returns "" if there are no radii.
std::string text_of(const RadiusScale& scale);

/// Sets the radii of `particles`. With `low` and `high`, a radius is a linear function of the
/// number, between `low` and `high`. If all numbers are equal, the radius is the mean of `low` and
/// `high`. Returns the numbers whose radii are `low` and `high`. Returns empty bounds if the number
/// itself is the radius.
///
/// Throws UnknownNumber (selection.h) if `scale.by` is a numeric column that the particles lack.
/// Throws SourceError with the key "radius_by" for another missing column, for a number that is not
/// known and for a radius outside ranges::length.
NumberBounds apply(const RadiusScale& scale, Particles& particles);

}  // namespace parray::input
