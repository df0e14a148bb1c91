#include "common/input/particle_source.h"

#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/input/json_fields.h"
#include "common/scene/limits.h"
#include "common/scene/scene_ranges.h"

namespace parray {
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
  static constexpr std::array<std::string_view, 4> keys{"file", "material", "radius", "frame"};
  const JsonFields fields(value, place, keys);
  ParticleSource out;
  out.line = out.material_line = out.radius_line = fields.line();
  out.file = fields.string("file");
  out.file_line = fields.find("file")->line;
  if (out.file.empty()) {
    place.at("file").fail(out.file_line, "the name is empty: write that of a particle file");
  }
  if (const JsonValue* material = fields.find("material")) {
    out.material = particle_material_from(read_string(*material, place.at("material")));
    out.material_line = material->line;
  }
  if (const JsonValue* radius = fields.find("radius")) {
    out.radius = read_radius(*radius, place.at("radius"));
    out.radius_line = radius->line;
  }
  if (fields.find("frame") != nullptr)
    out.frame = {fields.integer_or("frame", {0, limits::max_frame}, 0), false};
  return out;
}

}  // namespace parray
