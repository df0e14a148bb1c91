#include "cli/input/formats/autodock_types.h"

#include <array>
#include <utility>

#include "cli/input/particles/elements.h"
#include "common/base/ascii.h"

namespace parray::input {
namespace {

using TypeElement = std::pair<std::string_view, std::uint8_t>;

constexpr std::uint8_t hydrogen = 1;
constexpr std::uint8_t carbon = 6;
constexpr std::uint8_t nitrogen = 7;
constexpr std::uint8_t oxygen = 8;
constexpr std::uint8_t sulphur = 16;

/// Those that are no symbols, or other elements' symbols.
constexpr std::array<TypeElement, 17> elements_of_types{{{"HD", hydrogen},
                                                         {"HS", hydrogen},
                                                         {"A", carbon},
                                                         {"CX", carbon},
                                                         {"NA", nitrogen},
                                                         {"NS", nitrogen},
                                                         {"NX", nitrogen},
                                                         {"OA", oxygen},
                                                         {"OS", oxygen},
                                                         {"OX", oxygen},
                                                         {"W", oxygen},
                                                         {"SA", sulphur},
                                                         {"G", carbon},
                                                         {"GA", carbon},
                                                         {"J", carbon},
                                                         {"Q", carbon},
                                                         {"CG", carbon}}};

}  // namespace

std::uint8_t element_of_autodock_type(std::string_view type) {
  // "CG0" closes a ring with the pseudo-atom "G0"; "G" alone is a carbon of older versions.
  const bool numbered = !type.empty() && ascii::is_digit(type.back());
  while (!type.empty() && ascii::is_digit(type.back())) type.remove_suffix(1);
  if (numbered && type == "G") return 0;
  for (const auto& [name, element] : elements_of_types) {
    if (name == type) return element;
  }
  return atomic_number_of(type);
}

}  // namespace parray::input
