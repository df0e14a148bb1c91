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

/// A selection, or a part of it, as it was written: a condition that holds for a particle or does
/// not, or a number that each particle has. Plain data.
struct Expression {
  enum class Kind : std::uint8_t {
    // Conditions:
    all,
    none,
    both,      ///< all of the parts hold
    either,    ///< one of them does
    opposite,  ///< the one part does not
    less,      ///< compare the two parts; false for unknown numbers
    less_equal,
    equal,
    unequal,
    names,         ///< the particle's name in the column `word` is one of `words`
    elements,      ///< its element is one of `ranges`
    ranges,        ///< its number `word` ("index", "resid") is in one of `ranges`
    residues,      ///< its residue is of the kind `word`: "water", "protein", "nucleic", "ion"
    sites,         ///< the particle is a virtual site
    within,        ///< within the distance `number` of a particle for which the part holds
    same_residue,  ///< in one residue with a particle for which the part holds
    // Numbers:
    constant,  ///< `number`
    property,  ///< the particle's number `word`, as in columns.h
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
  std::size_t column = 1;  ///< in the text, from 1, counted in characters; 0: in no text
  std::size_t depth = 1;   ///< of the tree of parts below, this included
  double number = 0;
  std::string word{};
  std::vector<std::string> words{};  ///< in these, '*' stands for any characters
  std::vector<WholeRange> ranges{};  ///< in order, apart from each other
  std::vector<Expression> parts{};

  [[nodiscard]] bool is_number() const { return kind >= Kind::constant; }
};

/// Longest text of a selection in bytes, and its deepest nesting.
inline constexpr std::size_t max_selection_bytes = std::size_t{1} << 20;
inline constexpr std::size_t max_selection_depth = 64;

/// Parses a selection and returns a condition. scenes/README.md describes the language.
///
/// Throws InputError "column N: problem: remedy"; N counts characters from 1.
Expression parse_selection(std::string_view text);

/// Returns the words that are conditions by themselves: "water", "protein", ...
std::span<const std::string_view> selection_classes();

/// Returns a condition on the class `word`, one of selection_classes().
Expression class_condition(std::string_view word, std::size_t column = 1);

}  // namespace parray::input
