#include "cli/input/particles/elements.h"

#include <doctest/doctest.h>

#include <cctype>
#include <cmath>
#include <gemmi/elem.hpp>
#include <set>
#include <string>

#include "tests/support/rooms.h"

namespace parray {
namespace {

gemmi::Element gemmi_element(int number) { return gemmi::Element(number); }

/// Elements whose radii both tables take from Bondi and from Mantina and others.
bool is_main_group(int number) {
  const bool transition = (number >= 21 && number <= 30) || (number >= 39 && number <= 48) ||
                          (number >= 57 && number <= 80) || number >= 89;
  return !transition;
}

}  // namespace

TEST_CASE("the symbols of all 118 elements are gemmi's, and found in any letter case") {
  for (int number = 1; number <= last_element; ++number) {
    const std::string symbol = gemmi_element(number).name();
    const auto own = static_cast<std::uint8_t>(number);
    CHECK(element(own).symbol == symbol);
    std::string upper = symbol;
    std::string lower = symbol;
    for (char& c : upper) c = static_cast<char>(std::toupper(c));
    for (char& c : lower) c = static_cast<char>(std::tolower(c));
    CHECK(atomic_number_of(symbol) == own);
    CHECK(atomic_number_of(upper) == own);
    CHECK(atomic_number_of(lower) == own);
  }
}

TEST_CASE("deuterium and tritium are hydrogen, and other texts are unknown") {
  CHECK(atomic_number_of("D") == 1);
  CHECK(atomic_number_of("t") == 1);
  for (const char* text : {"", "X", "Xx", "C1", "Car", " C", "1", "\xC3\xA4"}) {
    CHECK(atomic_number_of(text) == 0);
  }
}

TEST_CASE("main-group radii agree with gemmi's to 0.1 angstrom, most of them exactly") {
  int different = 0;
  for (int number = 1; number < 89; ++number) {
    if (!is_main_group(number)) continue;
    const double own = element(static_cast<std::uint8_t>(number)).radius;
    const double other = static_cast<double>(gemmi_element(number).vdw_r());
    CAPTURE(number);
    CHECK(std::abs(own - other) <= 0.1001);
    different += std::abs(own - other) > 1e-3 ? 1 : 0;
  }
  CHECK(different == 3);  // H: 1.10, not 1.20; Li: 1.81, not 1.82; Br: 1.83, not 1.85
}

TEST_CASE("metals' radii are van der Waals radii, not the smaller ones that gemmi falls back to") {
  for (int number = 1; number <= 99; ++number) {
    const double own = element(static_cast<std::uint8_t>(number)).radius;
    CAPTURE(number);
    CHECK(own > 1.07 * static_cast<double>(gemmi_element(number).covalent_r()));
    if (!is_main_group(number)) CHECK(own > static_cast<double>(gemmi_element(number).vdw_r()));
    CHECK(own >= 1.1);
    CHECK(own <= 3.5);
  }
}

TEST_CASE("common radii equal those of their sources") {
  const auto radius = [](const char* symbol) { return element(atomic_number_of(symbol)).radius; };
  CHECK(radius("H") == 1.10);   // Rowland and Taylor
  CHECK(radius("C") == 1.70);   // Bondi
  CHECK(radius("N") == 1.55);   // Bondi
  CHECK(radius("O") == 1.52);   // Bondi
  CHECK(radius("Ca") == 2.31);  // Mantina and others
  CHECK(radius("Fe") == 2.44);  // Alvarez
  CHECK(radius("U") == 2.71);   // Alvarez
}

TEST_CASE("colours are Jmol's, converted to linear RGB") {
  CHECK(element(1).color == Vec3d{1, 1, 1});
  const Vec3d carbon = element(6).color;  // #909090
  CHECK(carbon.x == doctest::Approx(0.278894).epsilon(1e-5));
  CHECK(carbon.y == carbon.x);
  const Vec3d nitrogen = element(7).color;  // #3050F8
  CHECK(nitrogen.x == doctest::Approx(0.0295568).epsilon(1e-5));
  CHECK(nitrogen.y == doctest::Approx(0.0802198).epsilon(1e-5));
  CHECK(nitrogen.z == doctest::Approx(0.938686).epsilon(1e-5));
  const Vec3d oxygen = element(8).color;  // #FF0D0D: beside the curve's bend
  CHECK(oxygen.x == 1);
  CHECK(oxygen.y == doctest::Approx(0.00402472).epsilon(1e-5));
}

TEST_CASE("all colours are in [0, 1], and an unknown element has its own") {
  std::set<std::pair<double, double>> distinct;
  for (int number = 0; number <= last_element; ++number) {
    const Vec3d color = element(static_cast<std::uint8_t>(number)).color;
    for (const double c : {color.x, color.y, color.z}) CHECK((c >= 0 && c <= 1));
    distinct.insert({color.x, color.y});
  }
  CHECK(distinct.size() > 90);
  CHECK(element(0).radius == 1.7);
  CHECK(&element(119) == &element(0));
  CHECK(&element(255) == &element(0));
}

}  // namespace parray
