#include "cli/input/scene_file/label_settings.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "cli/input/scene_file/json_fields.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

std::string read_label_text(const JsonFields& fields, std::string_view key, std::size_t longest) {
  const JsonValue* const value = fields.find(key);
  if (value == nullptr) return {};
  const JsonPlace place = fields.place().at(key);
  const std::string& text = read_string(*value, place);
  const std::string problem = problem_with_label_text(text, longest);
  if (!problem.empty()) place.fail(value->line, problem);
  return text;
}

std::optional<double> read_size(const JsonFields& fields, std::string_view key, NumberRange range) {
  const JsonValue* const value = fields.find(key);
  if (value == nullptr) return std::nullopt;
  return read_number(*value, fields.place().at(key), range);
}

}  // namespace

std::string problem_with_label_text(std::string_view text, std::size_t longest) {
  if (text.empty()) return "empty: write what is to be shown";
  if (text.size() <= longest) return "";
  return std::to_string(text.size()) + " bytes: at most " + std::to_string(longest) +
         " are shown: make it shorter";
}

LabelSettings read_labels(const JsonValue& value, const JsonPlace& place) {
  static constexpr std::array<std::string_view, 9> keys{
      "legend", "scale_bar", "time_stamp", "cell", "text", "unit", "font_size", "dpi", "width_mm"};
  const JsonFields fields(value, place, keys);
  LabelSettings labels;
  labels.legend = fields.boolean_or("legend", false);
  labels.scale_bar = fields.boolean_or("scale_bar", false);
  labels.time_stamp = fields.boolean_or("time_stamp", false);
  labels.cell = fields.boolean_or("cell", false);
  labels.text = read_label_text(fields, "text", longest_label_text);
  labels.unit = read_label_text(fields, "unit", longest_unit);
  labels.font_size = read_size(fields, "font_size", drawing_ranges::font_size);
  labels.dpi = read_size(fields, "dpi", drawing_ranges::dpi);
  labels.width_mm = read_size(fields, "width_mm", drawing_ranges::print_width);
  if (labels.dpi && labels.width_mm) {
    place.at("dpi").fail(fields.find("dpi")->line,
                         "the picture's width in pixels and width_mm say how many pixels an inch "
                         "has: leave one of them out");
  }
  return labels;
}

std::string labels_text(const LabelSettings& labels) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  for (const auto& [key, wanted] : {std::pair("legend", labels.legend),
                                    {"scale_bar", labels.scale_bar},
                                    {"time_stamp", labels.time_stamp},
                                    {"cell", labels.cell}}) {
    if (wanted) out[key] = true;
  }
  if (!labels.text.empty()) out["text"] = labels.text;
  if (!labels.unit.empty()) out["unit"] = labels.unit;
  if (labels.font_size) out["font_size"] = *labels.font_size;
  if (labels.dpi) out["dpi"] = *labels.dpi;
  if (labels.width_mm) out["width_mm"] = *labels.width_mm;
  return out.dump();
}

std::string_view unit_sign(std::string_view unit) {
  if (unit == "angstrom") return "\u00c5";
  return unit == "um" ? "\u00b5m" : unit;
}

std::string_view length_unit_of(std::string_view format) {
  // What the formats' definitions say, of GRO, what its reader makes of nanometres, or, of XYZ,
  // what everybody writes.
  constexpr std::array<std::string_view, 9> in_angstrom{"PDB",   "mmCIF", "CIF",  "XYZ", "PQR",
                                                        "PDBQT", "SDF",   "MOL2", "GRO"};
  return std::ranges::find(in_angstrom, format) != in_angstrom.end() ? "angstrom" : "";
}

}  // namespace parray::input
