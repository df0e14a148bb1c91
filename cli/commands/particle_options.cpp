#include "cli/commands/particle_options.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "cli/commands/options.h"
#include "cli/commands/setting_options.h"
#include "cli/input/scene_file/particle_fields.h"
#include "cli/input/view/auto_scene.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray::commands {
namespace {

/// Throws InputError for the name of a material that automatic scenes lack.
void check_material(const ParticleMaterial& material) {
  if (material.rule != ParticleMaterial::Rule::named || material.name == plain_material_name) {
    return;
  }
  throw InputError("unknown material '" + printable(material.name) +
                   "': " + remedy_for_name(material.name, particle_rules::material_words));
}

/// Returns whether `value` is that of a flag that the user gave.
bool is_set_flag(const bool& value) { return value; }
template <typename T>
bool is_set_flag(const T& /*value of an option*/) {
  return false;
}

}  // namespace

void ParticleOptions::add_to(Command& command) {
  particle_fields(
      [&](const Setting& setting, const auto& rule, auto& value) {
        if (setting.help == nullptr) return;
        Option option = add_setting(command, setting, rule, value, [this, key = setting.key] {
          if (!is_given(key)) keys_.emplace_back(key);
          check_material(given_.look.material);
        });
        option.group(particles_group);
        if (setting.is(traits::special)) option.special();
      },
      given_);
}

bool ParticleOptions::is_given(std::string_view key) const {
  return std::ranges::find(keys_, key) != keys_.end();
}

void ParticleOptions::check_unused(const std::string& file) const {
  std::string given;
  particle_fields(
      [&](const Setting& setting, const auto& /*rule*/, const auto& value) {
        if (is_given(setting.key) || is_set_flag(value)) given += " " + option_of(setting);
      },
      given_);
  if (given.empty()) return;
  throw InputError(
      given.substr(1) + ": " + printable(file, 4096) +
      " is not a particle file: change its section \"particles\" instead of using options "
      "for particle files");
}

ParticleSource ParticleOptions::over(ParticleSource source) const {
  particle_fields(
      [&](const Setting& setting, const auto& /*rule*/, const auto& from, auto& to) {
        if (is_given(setting.key) || is_set_flag(from)) to = from;
      },
      given_, source);
  if (const auto problem = problem_with(source.look.coloring)) {
    throw InputError("--" + problem->key + " " + problem->text);
  }
  return source;
}

}  // namespace parray::commands
