
#include <doctest/doctest.h>

#include <cmath>
#include <gemmi/elem.hpp>
#include <set>
#include <utility>

#include "cli/input/particles/elements.h"
#include "tests/support/rooms.h"

namespace parray {

TEST_CASE("covalent radii agree with gemmi's, which come from the same source") {
  // gemmi has C of sp2, Mn, Fe and Co of high spin, and the radii of Lu and Hf in exchange.
  const std::set<int> others{6, 25, 26, 27, 71, 72};
  for (int number = 1; number <= 96; ++number) {
    if (others.contains(number)) continue;
    CAPTURE(number);
    const double other = static_cast<double>(gemmi::Element(number).covalent_r());
    CHECK(std::abs(covalent_radius(static_cast<std::uint8_t>(number)) - other) < 0.0051);
  }
}

TEST_CASE("metals have metallic radii, and other elements covalent ones") {
  const auto radius = [](const char* symbol) { return crystal_radius(atomic_number_of(symbol)); };
  CHECK(radius("Cu") == 1.28);
  CHECK(radius("Al") == 1.43);
  CHECK(radius("Na") == 1.86);
  CHECK(radius("Pb") == 1.75);
  for (const char* symbol : {"H", "C", "O", "Si", "Cl", "Ge", "Sn", "Bi"}) {
    CHECK(radius(symbol) == covalent_radius(atomic_number_of(symbol)));
  }
}

TEST_CASE("atoms of close-packed metals touch: radii are half the distance of neighbours") {
  // Edges of face-centred cubic cells in angstrom, from diffraction at room temperature.
  const auto gap = [](const char* symbol, double edge) {
    return edge * std::sqrt(0.5) - 2 * crystal_radius(atomic_number_of(symbol));
  };
  for (const auto& metal : {std::pair("Cu", 3.615), std::pair("Al", 4.050), std::pair("Ni", 3.524),
                            std::pair("Ag", 4.086), std::pair("Au", 4.078), std::pair("Pt", 3.924),
                            std::pair("Pb", 4.951)}) {
    const char* const symbol = metal.first;  // Clang 14 does not capture a structured binding
    CAPTURE(symbol);
    CHECK(std::abs(gap(symbol, metal.second)) < 0.02);
  }
}

TEST_CASE("every atomic number has a radius, and no radius exceeds that of van der Waals") {
  for (int number = 0; number <= 255; ++number) {
    const auto own = static_cast<std::uint8_t>(number);
    CAPTURE(number);
    CHECK(covalent_radius(own) > 0.2);
    CHECK(crystal_radius(own) > 0.2);
    if (number <= last_element) CHECK(crystal_radius(own) < element(own).radius + 1e-9);
  }
  CHECK(covalent_radius(0) == covalent_radius(6));
}

TEST_CASE("alkali metals and alkaline earths are ionic, hydrogen and transition metals are not") {
  for (const char* symbol : {"Li", "Na", "K", "Mg", "Ca", "Ba"}) {
    CHECK(is_ionic(atomic_number_of(symbol)));
  }
  for (const char* symbol : {"H", "C", "Fe", "Zn", "Al"}) {
    CHECK_FALSE(is_ionic(atomic_number_of(symbol)));
  }
}

}  // namespace parray
