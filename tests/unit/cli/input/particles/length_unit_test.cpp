#include "cli/input/particles/length_unit.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/rooms.h"

namespace parray {
namespace {

std::string shown(double length, const std::string& unit) {
  const ShownLength text = shown_length(length, unit);
  std::string value = std::to_string(text.value);
  value.erase(value.find_last_not_of("0") + 1);
  return value + (value.ends_with('.') ? "0 " : " ") + text.unit;
}

}  // namespace

TEST_CASE("units of length are known by names, signs and abbreviations") {
  for (const char* text : {"um", "UM", "\u00b5m", "\u03bcm", "\xb5m", "micron", "Micrometres"}) {
    CAPTURE(text);
    REQUIRE(length_unit(text) != nullptr);
    CHECK(length_unit(text)->name == "um");
  }
  for (const char* text : {"A", "\u00c5", "\u212b", "Angstrom", "ang"}) {
    CHECK(readable_unit(text) == "angstrom");
  }
  CHECK(readable_unit("MPC") == "Mpc");
  for (const char* text : {"a", "", "s", "m/s", "1", "px"}) CHECK(length_unit(text) == nullptr);
  CHECK(readable_unit("km/s") == "km/s");
  CHECK(readable_unit(std::string(41, 'a')).empty());
  CHECK(readable_unit("a\x1b[2J").empty());
  // NOLINTNEXTLINE(misc-misleading-bidirectional): such a character is what is refused
  CHECK(readable_unit("a\u202eb").empty());
  CHECK(readable_unit("\xff").empty());
  CHECK(readable_unit("\xc3").empty());
}

TEST_CASE("a length is shown in a unit that needs few digits") {
  CHECK(shown(0.05, "m") == "50.0 mm");
  CHECK(shown(0.1, "m") == "0.1 m");
  CHECK(shown(500, "m") == "500.0 m");
  CHECK(shown(1000, "m") == "1.0 km");
  CHECK(shown(2e-9, "m") == "2.0 nm");
  CHECK(shown(0.02, "cm") == "200.0 um");
  CHECK(shown(2000, "um") == "2.0 mm");
  CHECK(shown(2000, "pc") == "2.0 kpc");
  CHECK(shown(0.02, "kpc") == "20.0 pc");
  CHECK(shown(0.02, "pc") == "0.02 pc");
  CHECK(shown(5e7, "km") == "50000000.0 km");
  CHECK(shown(5000, "angstrom") == "5000.0 angstrom");
  CHECK(shown(0.001, "px") == "0.001 px");
  CHECK(shown(0.5, "") == "0.5 ");
}

TEST_CASE("styles of units in LAMMPS have a unit of length, except lj") {
  for (const char* style : {"real", "metal", "si", "cgs", "electron", "micro", "nano"}) {
    CHECK(length_unit(length_unit_of_lammps(style)) != nullptr);
  }
  CHECK(length_unit_of_lammps("lj").empty());
  CHECK(length_unit_of_lammps("").empty());
}

}  // namespace parray
