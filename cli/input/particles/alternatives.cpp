#include "cli/input/particles/alternatives.h"

namespace parray::input {

std::optional<AlternativeChoice> alternatives_from(std::string_view text) {
  using Rule = AlternativeChoice::Rule;
  if (text == "best") return AlternativeChoice{};
  if (text == "all") return AlternativeChoice{Rule::all, ' '};
  if (text.size() != 1 || text[0] <= ' ' || text[0] > '~') return {};
  return AlternativeChoice{Rule::letter, text[0]};
}

std::string text_of(const AlternativeChoice& choice) {
  switch (choice.rule) {
    case AlternativeChoice::Rule::best:
      return "best";
    case AlternativeChoice::Rule::all:
      return "all";
    case AlternativeChoice::Rule::letter:
      break;
  }
  return {choice.letter};
}

}  // namespace parray::input
