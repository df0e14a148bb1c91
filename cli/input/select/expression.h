#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/rooms.h"

namespace parray::input {

/// Whole numbers from `least` to `most`, both included.
struct WholeRange {
  std::int64_t least = 0;
  std::int64_t most = 0;
};

/// A selection as it was written, or a part of it: a condition, which holds for a particle or does
/// not, or a number that each particle has. Plain data.
struct Expression {
  enum class Kind : std::uint8_t {
    // Conditions:
    all,
    none,
    both,      ///< all of the parts hold
    either,    ///< one of them does
    opposite,  ///< the one part does not
    less,      ///< between the two parts, as those below; none holds for what is not known
    less_equal,
    equal,
    unequal,
    names,         ///< the particle's name in the column `word` is one of `words`
    elements,      ///< its element is one of `ranges`
    ranges,        ///< its number `word` ("index", "resid") is in one of `ranges`
    residues,      ///< its residue is of the kind `word`: "water", "protein", "nucleic", "ion"
    sites,         ///< it is a virtual site
    within,        ///< within the distance `number` of a particle for which the part holds
    same_residue,  ///< in one residue with a particle for which the part holds
    // Numbers:
    constant,  ///< `number`
    property,  ///< the particle's number `word`, as in number_source.h
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

}  // namespace parray::input
