#include "cli/input/scene_file/label_settings.h"

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

}  // namespace parray::input
