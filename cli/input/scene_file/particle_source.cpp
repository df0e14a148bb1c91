#include "cli/input/scene_file/particle_source.h"

#include "cli/input/scene_file/particle_fields.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

bool sets_colors(const ParticleMaterial& material) {
  using Rule = ParticleMaterial::Rule;
  return material.rule == Rule::by_element || material.rule == Rule::by_type ||
         material.rule == Rule::column;
}

std::optional<ColoringProblem> problem_with(const ParticleLook& look) {
  if (!look.radius_by.empty() && look.radius != ParticleRadius{}) {
    return ColoringProblem{"radius_by", "excludes \"radius\": leave out one of them"};
  }
  if (look.stick_radius && look.style == ParticleStyle::spheres) {
    return ColoringProblem{"stick_radius", "has no effect on \"style\" spheres: leave it out"};
  }
  return input::problem_with(look.coloring);
}

}  // namespace

ParticleLook completed(ParticleLook look, const ParticleLook& base) {
  const bool has_colors = sets_colors(look.material) || !look.coloring.empty();
  if (!has_colors) {
    look.coloring.by = base.coloring.by;
    if (!look.coloring.map) look.coloring.map = base.coloring.map;
    if (look.coloring.range.open()) look.coloring.range = base.coloring.range;
    if (!look.coloring.scale) look.coloring.scale = base.coloring.scale;
    if (look.coloring.names.empty()) look.coloring.names = base.coloring.names;
  }
  if (look.material == ParticleMaterial{} && !(has_colors && sets_colors(base.material))) {
    look.material = base.material;
  }
  if (look.radius == ParticleRadius{} && look.radius_by.empty()) {
    look.radius = base.radius;
    look.radius_by = base.radius_by;
  }
  if (look.style == ParticleStyle::automatic) look.style = base.style;
  if (!look.stick_radius && look.style != ParticleStyle::spheres) {
    look.stick_radius = base.stick_radius;
  }
  return look;
}

std::optional<SourceProblem> problem_with(const ParticleSource& source) {
  if (source.arrow_scale && source.arrows.empty()) {
    return SourceProblem{{"arrow_scale", "has no effect without \"arrows\": add it"}, {}};
  }
  if (const auto problem = problem_with(source.look)) return SourceProblem{*problem, {}};
  for (std::size_t i = 0; i < source.shows.size(); ++i) {
    const ParticleLook look = completed(source.shows[i].look, source.look);
    if (const auto problem = problem_with(look)) return SourceProblem{*problem, i};
  }
  return {};
}

std::string naming_options(std::string text) {
  particle_fields([&text](const Setting& setting, const auto& /*rule*/) {
    const std::string key = '"' + std::string(setting.key) + '"';
    for (std::size_t at = 0; (at = text.find(key, at)) != std::string::npos; ++at) {
      const bool quoted_by_user = at > 0 && text[at - 1] != ' ';
      if (!quoted_by_user) text.replace(at, key.size(), option_of(setting));
    }
  });
  return text;
}

ParticleMaterial particle_material_from(std::string_view text) {
  using Rule = ParticleMaterial::Rule;
  if (text == "by-element") return {Rule::by_element, {}};
  if (text == "by-type") return {Rule::by_type, {}};
  if (text == "column") return {Rule::column, {}};
  return {Rule::named, std::string(text)};
}

ParticleRadius particle_radius_from(std::string_view text) {
  using Rule = ParticleRadius::Rule;
  if (text == "by-element") return {Rule::by_element, 0};
  if (text == "covalent") return {Rule::covalent, 0};
  if (text == "column") return {Rule::column, 0};
  const std::optional<double> value = number_in(text);
  if (!value) {
    throw InputError("unknown radius '" + printable(text) + "': write a number or " +
                     list_names(particle_radius_words));
  }
  if (*value < ranges::length.least || *value > ranges::length.most) {
    throw InputError(printable(text) + " is out of range: use a number from " +
                     number_text(ranges::length.least) + " to " + number_text(ranges::length.most));
  }
  return {Rule::fixed, *value};
}

std::string text_of(const ParticleMaterial& material) {
  switch (material.rule) {
    case ParticleMaterial::Rule::automatic: break;
    case ParticleMaterial::Rule::named:
    case ParticleMaterial::Rule::color_by: return material.name;
    case ParticleMaterial::Rule::by_element: return "by-element";
    case ParticleMaterial::Rule::by_type: return "by-type";
    case ParticleMaterial::Rule::column: return "column";
  }
  return {};
}

std::string text_of(const ParticleRadius& radius) {
  switch (radius.rule) {
    case ParticleRadius::Rule::automatic: break;
    case ParticleRadius::Rule::fixed: return number_text(radius.value);
    case ParticleRadius::Rule::by_element: return "by-element";
    case ParticleRadius::Rule::covalent: return "covalent";
    case ParticleRadius::Rule::column: return "column";
  }
  return {};
}

}  // namespace parray::input
