#include "cli/input/scene_file/particle_source.h"

#include <limits>

#include "cli/input/scene_file/json_fields.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/scene/limits.h"
#include "common/scene/scene_ranges.h"

namespace parray::input {
namespace {

ParticleRadius read_radius(const JsonValue& value, const JsonPlace& place) {
  if (value.kind != JsonKind::string) {
    return {ParticleRadius::Rule::fixed, read_number(value, place, ranges::length)};
  }
  const std::optional<ParticleRadius> radius = particle_radius_from(value.text);
  if (radius) return *radius;
  place.fail(value.line, "unknown radius '" + printable(value.text) + "': write a number or " +
                             list_names(particle_radius_words));
}

FrameChoice read_frame_choice(const JsonValue& value, const JsonPlace& place) {
  if (value.kind != JsonKind::string) {
    return {read_integer(value, place, {0, limits::max_frame}), false};
  }
  if (value.text == last_frame_word) return {0, true};
  place.fail(value.line,
             "'" + printable(value.text) + "' is not a frame: write a number, from 0, or \"last\"");
}

AlternativeChoice read_alternatives(const JsonValue& value, const JsonPlace& place) {
  const auto choice = alternatives_from(read_string(value, place));
  if (choice) return *choice;
  place.fail(value.line,
             "unknown alternatives '" + printable(value.text) + "': write best, all or one letter");
}

TextRange range_in(const JsonValue& value, const JsonPlace& place) {
  if (value.kind != JsonKind::array) {
    try {
      return color_range_from(read_string(value, place));
    } catch (const InputError&) {
      place.fail(value.line,
                 "this is not a range: write [low, high], or a text such as \"1%:99%\"");
    }
  }
  constexpr NumberRange finite{std::numeric_limits<double>::lowest(),
                               std::numeric_limits<double>::max()};
  if (value.items.size() != 2) {
    place.fail(value.line, "the array does not have two numbers: write [low, high]");
  }
  const TextRange range{RangeEnd{read_number(value.items[0], place.at(0), finite)},
                        RangeEnd{read_number(value.items[1], place.at(1), finite)}};
  if (!(range.low->value < range.high->value)) {
    place.fail(value.line, "low is not below high: write [low, high]");
  }
  return range;
}

/// If the key exists, sets `member` to the result of `from` for its text. Adds the place to errors
/// of `from`.
template <typename Member, typename From>
void take(const JsonFields& fields, const char* key, const From& from, Member& member) {
  const JsonValue* const value = fields.find(key);
  if (value == nullptr) return;
  const std::string& text = fields.string(key);
  try {
    member = from(text);
  } catch (const InputError& error) {
    fields.place().at(key).fail(value->line, error.what());
  }
}

ParticleFilter read_filter(const JsonFields& fields) {
  ParticleFilter out;
  take(fields, "select", select_from, out.select);
  take(fields, "slice", slice_from, out.slice);
  const JsonValue* const hide = fields.find("hide");
  if (hide == nullptr) return out;
  const JsonPlace place = fields.place().at("hide");
  if (hide->kind != JsonKind::array) {
    place.fail(hide->line,
               "this is not a list: write words in brackets, such as [\"virtual\", \"water\"]");
  }
  out.hide.emplace();
  for (std::size_t i = 0; i < hide->items.size(); ++i) {
    out.hide->push_back(read_string(hide->items[i], place.at(i)));
  }
  try {
    check_hidden(*out.hide);
  } catch (const InputError& error) {
    place.fail(hide->line, error.what());
  }
  return out;
}

ParticleColoring read_coloring(const JsonFields& fields) {
  ParticleColoring out;
  take(fields, "color_by", color_by_from, out.by);
  take(fields, "colormap", color_map_from, out.map);
  if (const JsonValue* range = fields.find("range")) {
    out.range = range_in(*range, fields.place().at("range"));
  }
  if (const auto problem = problem_with(out)) {
    fields.place().at(problem->key).fail(fields.find(problem->key)->line, problem->text);
  }
  return out;
}

}  // namespace

ParticleMaterial particle_material_from(std::string_view text) {
  using Rule = ParticleMaterial::Rule;
  if (text == "by-element") return {Rule::by_element, {}};
  if (text == "by-type") return {Rule::by_type, {}};
  if (text == "column") return {Rule::column, {}};
  return {Rule::named, std::string(text)};
}

std::optional<ParticleRadius> particle_radius_from(std::string_view text) {
  if (text == "by-element") return ParticleRadius{ParticleRadius::Rule::by_element, 0};
  if (text == "column") return ParticleRadius{ParticleRadius::Rule::column, 0};
  return {};
}

std::string text_of(const ParticleMaterial& material) {
  switch (material.rule) {
    case ParticleMaterial::Rule::automatic:
      break;
    case ParticleMaterial::Rule::named:
    case ParticleMaterial::Rule::color_by:
      return material.name;
    case ParticleMaterial::Rule::by_element:
      return "by-element";
    case ParticleMaterial::Rule::by_type:
      return "by-type";
    case ParticleMaterial::Rule::column:
      return "column";
  }
  return {};
}

std::string text_of(const ParticleRadius& radius) {
  if (radius.rule == ParticleRadius::Rule::by_element) return "by-element";
  return radius.rule == ParticleRadius::Rule::column ? "column" : "";
}

ParticleSource read_particle_source(const JsonValue& value, const JsonPlace& place) {
  static constexpr std::array<std::string_view, 12> keys{
      "file",   "material", "radius", "frame",    "topology", "alternatives",
      "select", "slice",    "hide",   "color_by", "colormap", "range"};
  const JsonFields fields(value, place, keys);
  ParticleSource out;
  out.line = fields.line();
  for (const JsonMember& member : value.members) out.lines.emplace(member.key, member.value.line);
  out.file = fields.string("file");
  out.file_line = out.line_of("file");
  if (out.file.empty()) {
    place.at("file").fail(out.file_line, "the name is empty: write the name of a particle file");
  }
  if (fields.find("topology") != nullptr) out.topology = fields.string("topology");
  if (const JsonValue* material = fields.find("material")) {
    out.material = particle_material_from(read_string(*material, place.at("material")));
  }
  if (const JsonValue* radius = fields.find("radius")) {
    out.radius = read_radius(*radius, place.at("radius"));
  }
  if (const JsonValue* frame = fields.find("frame")) {
    out.frame = read_frame_choice(*frame, place.at("frame"));
  }
  out.filter = read_filter(fields);
  out.coloring = read_coloring(fields);
  if (const JsonValue* choice = fields.find("alternatives")) {
    out.alternatives = read_alternatives(*choice, place.at("alternatives"));
  }
  return out;
}

}  // namespace parray::input
