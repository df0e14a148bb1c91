#include "cli/input/scene_file/label_settings.h"

#include <algorithm>
#include <array>

namespace parray::input {
std::string problem_with_label_text(std::string_view text, std::size_t longest) {
  if (text.empty()) return "the text is empty: write the text to be shown";
  if (text.size() <= longest) return "";
  return "the text has " + std::to_string(text.size()) + " bytes, more than " +
         std::to_string(longest) + ": shorten it";
}

std::string_view unit_sign(std::string_view unit) {
  if (unit == "angstrom") return "\u00c5";
  return unit == "um" ? "\u00b5m" : unit;
}

std::string_view length_unit_of(std::string_view format) {
  // The unit follows from the definition of the format. The reader of GRO converts nanometres.
  // Files of XYZ are in angstrom by convention.
  constexpr std::array<std::string_view, 9> in_angstrom{"PDB", "CIF",  "XYZ", "PQR",   "PDBQT",
                                                        "SDF", "MOL2", "GRO", "POSCAR"};
  return std::ranges::find(in_angstrom, format) != in_angstrom.end() ? "angstrom" : "";
}

}  // namespace parray::input
