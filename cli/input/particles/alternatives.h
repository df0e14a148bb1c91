#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "common/rooms.h"

namespace parray::input {

/// Which of an atom's alternative locations are read.
struct AlternativeChoice {
  enum class Rule : std::uint8_t {
    best,   ///< the one of the highest occupancy, the first of equals
    all,    ///< all of them
    letter  ///< the one of this letter; of an atom without it, the best
  };
  Rule rule = Rule::best;
  char letter = ' ';

  friend bool operator==(const AlternativeChoice&, const AlternativeChoice&) = default;
};

/// "best", "all" or one letter or digit; nothing for any other text.
std::optional<AlternativeChoice> alternatives_from(std::string_view text);

/// The text that is read as this.
std::string text_of(const AlternativeChoice& choice);

}  // namespace parray::input
