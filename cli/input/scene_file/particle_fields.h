#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "cli/input/particles/arrows.h"
#include "cli/input/scene_file/particle_source.h"
#include "cli/input/scene_file/scene_fields.h"
#include "common/scene/setting_rules.h"

/// Descriptions of an item of the section `particles`. They work like the descriptions of settings
/// (settings_fields.h).
namespace parray::input {

/// The JSON that a member accepts beside a text.
enum class JsonForm : std::uint8_t {
  text,    ///< none
  number,  ///< a number
  pair     ///< [low, high]: the text "low:high"
};

/// The rule of a member that options and scene files write as the same text.
template <typename T>
struct TextRule {
  T (*parse)(std::string_view);   ///< throws InputError, which names no place, for invalid texts
  std::string (*text)(const T&);  ///< the text that parse() reads; "": the default
  JsonForm form = JsonForm::text;
  std::span<const std::string_view> words{};  ///< known texts, for help and shells
};

struct FileName {};         ///< the name of a file; not empty
struct Representations {};  ///< a list of objects with `select` and the members of ParticleLook
struct HiddenClasses {};    ///< words of selection_classes(): a list in JSON

namespace particle_rules {

inline std::string same_text(const std::string& text) { return text; }
std::string text_by_overload(const auto& value) { return text_of(value); }

/// Known texts of the option `--material`: rules, and the material of automatic scenes.
inline constexpr std::array<std::string_view, 4> material_words{"by-element", "by-type", "column",
                                                                "plain"};
inline constexpr std::array<std::string_view, 1> frame_words{last_frame_word};
inline constexpr std::array<std::string_view, 2> alternative_words{"best", "all"};

inline constexpr TextRule<ParticleMaterial> material{particle_material_from, text_by_overload,
                                                     JsonForm::text, material_words};
inline constexpr TextRule<ParticleRadius> radius{particle_radius_from, text_by_overload,
                                                 JsonForm::number, particle_radius_words};
inline constexpr TextRule<RadiusScale> radius_by{radius_scale_from, text_by_overload};
inline constexpr TextRule<std::string> color_by{color_by_from, same_text, JsonForm::text,
                                                color_by_words};
inline constexpr TextRule<std::optional<ColorMap>> color_map{
    color_map_from, text_by_overload, JsonForm::text, picture::color_map_words};
inline constexpr TextRule<std::optional<NumberScale>> color_scale{
    number_scale_from, text_by_overload, JsonForm::text, number_scale_words};
inline constexpr TextRule<TextRange> range{color_range_from, text_by_overload, JsonForm::pair};
inline constexpr TextRule<std::optional<FrameChoice>> frame{frame_from, text_by_overload,
                                                            JsonForm::number, frame_words};
inline constexpr TextRule<AlternativeChoice> alternatives{alternatives_from, text_by_overload,
                                                          JsonForm::text, alternative_words};
inline constexpr TextRule<Replicas> replicas{replicas_from, text_by_overload};
inline constexpr TextRule<std::string> select{select_from, same_text};
inline constexpr TextRule<std::string> slice{slice_from, same_text};
inline constexpr TextRule<std::string> arrows{arrows_from, same_text, JsonForm::text, arrow_words};
inline constexpr scene::Words style{"style of particles", particle_style_words};
inline constexpr scene::Words bonds{"source of bonds", bond_source_words};

}  // namespace particle_rules

/// Visits the members of ParticleLook.
template <typename F, typename... S>
void look_fields(F&& f, S&... s) {
  using namespace traits;
  f({"style"}, particle_rules::style, s.style...);  // an option of the whole picture, too
  f({"stick_radius",
     "Radius of sticks, in the file's unit of length (default: 0.15 angstrom or, without elements, "
     "a tenth of the mean bond)",
     special, "R"},
    ranges::length, s.stick_radius...);
  f({"material",
     "Surface of the particles. column: the colours in the file (default: column, else by-element, "
     "else by-type, else plain)",
     special},
    particle_rules::material, s.material...);
  f({"radius",
     "Radius of the particles. by-element: van der Waals; covalent: covalent or, for metals, "
     "metallic; column: the radii in the file (default: column, else by-element or, for crystals, "
     "covalent, else half the mean spacing)",
     special, "R|by-element|covalent|column"},
    particle_rules::radius, s.radius...);
  f({"radius_by",
     "Take the radius of each particle from a numeric column, such as mass: its number is the "
     "radius. With LOW:HIGH the least number gets the radius LOW, and the largest HIGH",
     special, "COLUMN[:LOW:HIGH]"},
    particle_rules::radius_by, s.radius_by...);
  f({"color_by",
     "Colour the particles by a category, or by a number such as vx, charge, b_factor or z", 0,
     "WORD|NUMBER"},
    particle_rules::color_by, s.coloring.by...);
  f({"colormap", "Colour map for numbers, from low to high (default: viridis)", special},
    particle_rules::color_map, s.coloring.map...);
  f({"range",
     "Values at the ends of the colour map: two numbers, or percentiles such as 1%:99% (default: "
     "the smallest and the largest value; a diverging map is symmetric if both signs occur)",
     special, "LOW:HIGH"},
    particle_rules::range, s.coloring.range...);
  f({"color_scale",
     "How numbers get colours. log: in equal steps of the logarithm, for numbers above 0. "
     "categories: each number is a category, with one of 24 colours in turn (default: linear)",
     special},
    particle_rules::color_scale, s.coloring.scale...);
}

/// Visits the members of Representation.
template <typename F, typename... S>
void representation_fields(F&& f, S&... s) {
  f({"select", nullptr, traits::required}, particle_rules::select, s.select...);
  look_fields(f, s.look...);
}

/// Visits the members of ParticleSource.
template <typename F, typename... S>
void particle_fields(F&& f, S&... s) {
  using namespace traits;
  f({"file", nullptr, required}, FileName{}, s.file...);
  f({"topology",
     "File with the elements and names for a trajectory that lacks them: PDB, PSF, PRMTOP ...",
     special, "FILE"},
    FileName{}, s.topology...);
  f({"frame", "Frame of the file, from 0 (default: the first frame that has particles)", special,
     "N|last"},
    particle_rules::frame, s.frame...);
  f({"alternatives",
     "Alternative locations of an atom to show: best (highest occupancy), all, or those with a "
     "letter (default: best)",
     special, "best|all|LETTER"},
    particle_rules::alternatives, s.alternatives...);
  f({"crystal",
     "Draw a crystal: covalent radii, copies of atoms on the faces of the cell, and the cell "
     "(default: on for a file with a periodic cell, no residues, no chains and at most 500 atoms)",
     special},
    OnOff{}, s.cell.crystal...);
  f({"replicate", "Repeat the cell along its edges a, b and c, such as 3x3x2", special, "AxBxC"},
    particle_rules::replicas, s.cell.replicate...);
  f({"wrap", "Move particles into the cell; with --whole, whole molecules", special}, Flag{},
    s.cell.wrap...);
  f({"whole",
     "Join molecules that the faces of the cell break, by bonds between close atoms or, without "
     "elements, by molecule or residue numbers",
     special},
    Flag{}, s.cell.whole...);
  f({"center",
     "Move all particles so that the centroid of the selected ones, such as 'resname LIG', is at "
     "the centre of the cell; then wrap",
     special, "TEXT"},
    particle_rules::select, s.cell.center...);
  f({"bonds",
     "Bonds that sticks show. auto: those of the file and, unless it states all, those of close "
     "atoms. file: only those of the file (default: auto)",
     special},
    particle_rules::bonds, s.bonds...);
  f({"arrows",
     "Draw a vector of each particle as an arrow: velocity, force, the name of a vector, or three "
     "columns such as mux,muy,muz",
     special, "VECTOR"},
    particle_rules::arrows, s.arrows...);
  f({"arrow_scale",
     "Length of the arrow of a vector of length 1 (default: the longest arrow is twice as long as "
     "the distance of neighbours)",
     special, "X"},
    ranges::length, s.arrow_scale...);
  f({"solid_cell", "Draw the edges of the cell as rods, which cast shadows", special}, Flag{},
    s.solid_cell...);
  f({"select",
     "Show only these particles: 'chain A B and not water', 'element C N O', 'z > 10', 'within 5 "
     "of resname HEM' (scenes/README.md describes the language)",
     0, "TEXT"},
    particle_rules::select, s.filter.select...);
  f({"slice",
     "Show only the particles of a slice: z=10:20, or z=40%:60% of the cell. Separate several "
     "slices by commas",
     special, "AXIS=LOW:HIGH"},
    particle_rules::slice, s.filter.slice...);
  f({"hide",
     "Hide these classes. Virtual sites are always hidden, except with `none` (default: virtual)",
     traits::special},
    HiddenClasses{}, s.filter.hide...);
  f({"show",
     "Show these particles with a look of their own, which the options after this one describe, "
     "such as --color-by and --radius. If several --show select a particle, the last one counts",
     0, "TEXT"},
    Representations{}, s.shows...);
  look_fields(f, s.look...);
}

}  // namespace parray::input
