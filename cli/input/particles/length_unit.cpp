#include "cli/input/particles/length_unit.h"

#include <algorithm>
#include <array>
#include <span>

#include "cli/input/scene_file/label_settings.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::array<LengthUnit, 15> length_units{{
    {"fm", 1e-15},
    {"pm", 1e-12},
    {"nm", 1e-9},
    {"um", 1e-6},
    {"mm", 1e-3},
    {"cm", 1e-2},
    {"m", 1},
    {"km", 1e3},
    {"angstrom", 1e-10},
    {"bohr", 5.29177210903e-11},    // CODATA 2018
    {"pc", 3.0856775814913673e16},  // IAU 2015, resolution B2
    {"kpc", 3.0856775814913673e19},
    {"Mpc", 3.0856775814913673e22},
    {"ly", 9.4607304725808e15},  // Julian year times the speed of light
    {"au", 0},                   // astronomical or atomic
}};

struct OtherName {
  std::string_view text;  ///< lower case
  std::string_view unit;
};

constexpr std::array<OtherName, 34> other_names{{
    {"\u00b5m", "um"},      {"\u03bcm", "um"},         {"\xb5m", "um"},
    {"micron", "um"},       {"microns", "um"},         {"micrometer", "um"},
    {"micrometers", "um"},  {"micrometre", "um"},      {"micrometres", "um"},
    {"\u00c5", "angstrom"}, {"\u212b", "angstrom"},    {"\xc5", "angstrom"},
    {"ang", "angstrom"},    {"angstroms", "angstrom"}, {"\u00e5ngstr\u00f6m", "angstrom"},
    {"meter", "m"},         {"meters", "m"},           {"metre", "m"},
    {"metres", "m"},        {"millimeter", "mm"},      {"millimeters", "mm"},
    {"millimetre", "mm"},   {"millimetres", "mm"},     {"centimeter", "cm"},
    {"centimeters", "cm"},  {"centimetre", "cm"},      {"centimetres", "cm"},
    {"nanometer", "nm"},    {"nanometers", "nm"},      {"nanometre", "nm"},
    {"nanometres", "nm"},   {"parsec", "pc"},          {"parsecs", "pc"},
    {"lightyear", "ly"},
}};

/// Units that differ by a prefix, ascending. Centimetres are shown as millimetres or metres.
constexpr std::array<std::string_view, 7> metric_units{"fm", "pm", "nm", "um", "mm", "m", "km"};
constexpr std::array<std::string_view, 3> parsec_units{"pc", "kpc", "Mpc"};

const LengthUnit* unit_named(std::string_view name) {
  const auto* const found = std::ranges::find_if(
      length_units, [&](const LengthUnit& unit) { return lower_case(unit.name) == name; });
  return found == length_units.end() ? nullptr : found;
}

std::span<const std::string_view> family_of(std::string_view unit) {
  if (unit == "cm" || place_in(metric_units, unit)) return metric_units;
  if (place_in(parsec_units, unit)) return parsec_units;
  return {};
}

}  // namespace

const LengthUnit* length_unit(std::string_view text) {
  if (text == "A") return unit_named("angstrom");
  const std::string lower = lower_case(text);
  const auto* const other = std::ranges::find(other_names, lower, &OtherName::text);
  if (other != other_names.end()) return unit_named(other->unit);
  return unit_named(lower);
}

std::string readable_unit(std::string_view text) {
  if (const LengthUnit* const length = length_unit(text)) return std::string(length->name);
  return text.size() <= longest_unit && printable(text) == text ? std::string(text) : "";
}

std::string_view length_unit_of_lammps(std::string_view style) {
  if (style == "real" || style == "metal") return "angstrom";
  if (style == "si") return "m";
  if (style == "cgs") return "cm";
  if (style == "electron") return "bohr";
  if (style == "micro") return "um";
  return style == "nano" ? "nm" : "";
}

ShownLength shown_length(double length, std::string_view unit) {
  const LengthUnit* const known = length_unit(unit);
  constexpr double low = 0.1;
  constexpr double high = 1000;
  constexpr double slack = 1e-6;
  const bool handy = length >= low * (1 - slack) && length < high * (1 - slack);
  const auto family =
      known == nullptr ? std::span<const std::string_view>() : family_of(known->name);
  if (handy || family.empty()) return {length, std::string(unit)};
  ShownLength shown;
  for (const std::string_view name : family) {
    const double value = length * (known->metres / unit_named(lower_case(name))->metres);
    if (!shown.unit.empty() && value < 1 - slack) break;
    shown = {value, std::string(name)};
  }
  return shown;
}

}  // namespace parray::input
