#include "cli/input/scene_file/particle_source.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/scene_file/particle_fields.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/selection.h"
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

/// Returns "mass of particle 7", with the particle's index in the file.
std::string number_of_particle(const std::string& by, const Particles& particles,
                               std::ptrdiff_t place) {
  return printable(by) + " of particle " +
         std::to_string(particles.index_of(static_cast<std::size_t>(place)));
}

bool is_radius(double value) {
  return value >= ranges::length.least && value <= ranges::length.most;  // false for NaN
}

/// Returns the number of each particle. All are finite.
std::vector<double> numbers_in(const Particles& particles, const std::string& by) {
  const NumberSource source = known_number("radius_by", by, particles);
  std::vector<double> numbers(particles.count());
  source(0, numbers);
  const auto unknown = std::ranges::find_if_not(numbers, [](double v) { return std::isfinite(v); });
  if (unknown != numbers.end()) {
    throw SourceError("radius_by", number_of_particle(by, particles, unknown - numbers.begin()) +
                                       " is not known: select particles with a known number");
  }
  return numbers;
}

/// Replaces the numbers by radii from `low` to `high`. Returns the numbers with these radii.
NumberBounds scale_to(const RadiusScale& scale, std::vector<double>& numbers) {
  NumberBounds bounds = scale.numbers;
  if (bounds.empty()) std::ranges::for_each(numbers, [&](double number) { bounds.add(number); });
  const auto [least, most] = bounds;
  const auto [low, high] = std::pair(scale.low, scale.high);
  for (double& number : numbers) {
    // Halves, because the difference may overflow.
    const double share = least < most ? (number / 2 - least / 2) / (most / 2 - least / 2) : 0.5;
    number = std::clamp(low + share * (high - low), low, high);
  }
  return bounds;
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

RadiusScale radius_scale_from(std::string_view text) {
  // One colon is part of a name, such as velocity:0.
  const bool scaled = std::ranges::count(text, ':') >= 2;
  const std::size_t second = scaled ? text.rfind(':') : text.size();
  const std::size_t first = scaled ? text.rfind(':', second - 1) : text.size();
  RadiusScale scale{lower_case(trimmed(text.substr(0, first)))};
  bool valid = !scale.by.empty() && scale.by.front() != ':' && scale.by.back() != ':';
  if (scaled) {
    scale.low = number_or_nan(trimmed(text.substr(first + 1, second - first - 1)));
    scale.high = number_or_nan(trimmed(text.substr(second + 1)));
    valid = valid && is_radius(scale.low) && is_radius(scale.high) && scale.low < scale.high;
  }
  if (valid) return scale;
  throw InputError("'" + printable(text) +
                   "' does not name radii: write a numeric column, or COLUMN:LOW:HIGH with two "
                   "ascending radii such as mass:0.5:2");
}

std::string text_of(const RadiusScale& scale) {
  if (scale.low == 0) return scale.by;
  return scale.by + ":" + number_text(scale.low) + ":" + number_text(scale.high);
}

NumberBounds apply(const RadiusScale& scale, Particles& particles) {
  if (particles.count() == 0) return {};
  std::vector<double> radii = numbers_in(particles, scale.by);
  const NumberBounds sized = scale.low > 0 ? scale_to(scale, radii) : NumberBounds{};
  const auto wrong = std::ranges::find_if_not(radii, is_radius);
  if (wrong != radii.end()) {
    throw SourceError("radius_by", number_of_particle(scale.by, particles, wrong - radii.begin()) +
                                       " is " + number_text(*wrong) +
                                       ", which is not a radius: write " + printable(scale.by) +
                                       ":LOW:HIGH to scale the numbers");
  }
  particles.radii = std::move(radii);
  return sized;
}

}  // namespace parray::input
