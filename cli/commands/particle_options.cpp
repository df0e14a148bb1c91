#include "cli/commands/particle_options.h"

#include <algorithm>
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
bool is_set_flag(const auto& /*value of an option*/) { return false; }

}  // namespace

void ParticleOptions::add_to(Command& command) {
  particle_fields(
      [&]<typename Rule>(const Setting& setting, const Rule& rule, auto& value) {
        if (setting.help == nullptr) return;
        const auto note = [this, key = setting.key] {
          if (std::ranges::find(keys_, key) == keys_.end()) keys_.emplace_back(key);
          check_material(given_.look.material);
        };
        const auto declare = [&] {
          if constexpr (std::is_same_v<Rule, Representations>) {
            return command
                .option(
                    option_of(setting),
                    [this, note](const std::string& text) {
                      begin_representation(text);
                      note();
                    },
                    setting.help)
                .type_name(setting.value);
          } else {
            return add_setting(command, setting, rule, value, note);
          }
        };
        Option option = declare();
        option.group(particles_group).in_order();
        if (setting.is(traits::special)) option.special();
      },
      given_);
}

void ParticleOptions::begin_representation(const std::string& select) {
  if (given_.shows.size() == max_representations) {
    throw InputError("more than " + std::to_string(max_representations) +
                     " representations: use fewer");
  }
  Representation next{select_from(select)};
  (given_.shows.empty() ? base_ : given_.shows.back().look) = std::exchange(given_.look, {});
  given_.shows.push_back(std::move(next));
}

void ParticleOptions::check_unused(const std::string& file) const {
  std::string given;
  particle_fields(
      [&](const Setting& setting, const auto& /*rule*/, const auto& value) {
        const bool is_given = std::ranges::find(keys_, setting.key) != keys_.end();
        if (is_given || is_set_flag(value)) given += " " + option_of(setting);
      },
      given_);
  if (given.empty()) return;
  throw InputError(
      given.substr(1) + ": " + printable(file, 4096) +
      " is not a particle file but a scene: leave out the options or, if the scene has a section "
      "\"particles\", write them there");
}

ParticleSource ParticleOptions::source() const {
  ParticleSource source = given_;
  if (!source.shows.empty()) {
    source.shows.back().look = source.look;
    source.look = base_;
  }
  if (const auto problem = problem_with(source)) {
    throw InputError(naming_options('"' + problem->key + "\" " + problem->text));
  }
  return source;
}

}  // namespace parray::commands
