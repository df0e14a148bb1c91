#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

namespace parray::input {

/// Whole numbers from `least` to `most`, both included.
struct WholeRange {
  std::int64_t least = 0;
  std::int64_t most = 0;
};

/// A selection or a part of it in the form of a tree: a condition that each particle satisfies or
/// not, or a number that each particle has. Plain data.
struct Expression {
  enum class Kind : std::uint8_t {
    // Conditions:
    all,
    none,
    both,      ///< all parts hold
    either,    ///< at least one part holds
    opposite,  ///< the only part does not hold
    less,      ///< compares two numbers, as do the next three; false if one is unknown
    less_equal,
    equal,
    unequal,
    names,         ///< the particle's name in the column `word` is one of `words`
    elements,      ///< the particle's atomic number, 0 for unknown, is in one of `ranges`
    ranges,        ///< the particle's number `word` ("index", "resid") is in one of `ranges`
    residues,      ///< the particle's residue is of the kind `word`: "water", "protein",
                   ///< "nucleic"; "ion" also depends on the atom's name (is_ion())
    sites,         ///< the particle is a virtual site (residues.h)
    within,        ///< at most `number` (in the unit of positions) away from a particle that
                   ///< satisfies the part; such particles satisfy `within`, too; distances do not
                   ///< cross faces of the cell
    same_residue,  ///< in the same residue as a particle that satisfies the part
    // Numbers:
    constant,  ///< `number`
    property,  ///< the particle's number `word` (columns.h)
    add,
    subtract,
    multiply,
    divide,
    remainder,
    negate,
    absolute,
    square_root,
  };
  Kind kind = Kind::all;
  std::size_t column = 1;  ///< place in the text: characters, from 1; 0: from no text
  std::size_t depth = 1;   ///< depth of this tree, including this node
  double number = 0;
  std::string word{};
  /// Names. '*' stands for any characters, "'" also for the '*' of old names of nucleic acids.
  /// Letter case matters.
  std::vector<std::string> words{};
  std::vector<WholeRange> ranges{};  ///< ascending and disjoint
  std::vector<Expression> parts{};

  [[nodiscard]] bool is_number() const { return kind >= Kind::constant; }
};

/// Limits of a selection: length of its text in bytes, depth of its tree.
inline constexpr std::size_t max_selection_bytes = std::size_t{1} << 20;
inline constexpr std::size_t max_selection_depth = 64;

/// Parses a selection. Returns a condition. scenes/README.md describes the language.
///
/// Throws InputError "character N: problem: remedy"; N counts characters from 1.
Expression parse_selection(std::string_view text);

/// Returns the words that are conditions on their own: "water", "protein", ...
std::span<const std::string_view> selection_classes();

/// Returns a condition on the class `word`, one of selection_classes(). `column` is the word's
/// place in the text; 0: from no text.
Expression class_condition(std::string_view word, std::size_t column = 1);

}  // namespace parray::input
