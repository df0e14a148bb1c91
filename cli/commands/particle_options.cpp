#include "cli/commands/particle_options.h"

#include <algorithm>
#include <array>
#include <span>

#include "cli/commands/options.h"
#include "cli/commands/setting_options.h"
#include "cli/input/scene_file/particle_fields.h"
#include "cli/input/scene_file/scene_fields.h"
#include "cli/input/view/auto_scene.h"
#include "cli/output/picture/srgb.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/base/text.h"

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

Projection projection_in(const std::string& text) {
  return static_cast<Projection>(known_place("projection", text, scene_words::projections));
}

/// Parses a colour: a word, or the sRGB code of a web page. Returns linear RGB.
Vec3d color_from(const std::string& text) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 4> words{
      {{"white", "#ffffff"}, {"black", "#000000"}, {"grey", "#808080"}, {"gray", "#808080"}}};
  std::string code = text;
  for (const auto& [word, meaning] : words) {
    if (text == word) code = meaning;
  }
  const auto rgb =
      code.size() == 7 && code[0] == '#' ? parsed<std::uint32_t>(code.substr(1), 16) : std::nullopt;
  if (!rgb) {
    throw InputError("'" + printable(text) +
                     "' is not a colour: write white, black, grey, or a code such as #1e90ff");
  }
  return linear_of_code(*rgb);
}

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

std::vector<std::string> view_words() {
  std::vector<std::string> words(view_names.begin(), view_names.end());
  words.insert(words.end(), view_axes.begin(), view_axes.end());
  return words;
}

void AutoSceneOptions::add_to(Command& command, ParticleOptions& particles) {
  command.section(particles_group);
  command
      .option(
          "--view", [this](const std::string& text) { view_ = named_view(text); },
          "Side of the view, or the axis that points at the viewer. z points up; from top and "
          "bottom y does (default: auto: molecules along their principal axes, flat groups face "
          "on, others obliquely from above)")
      .words(view_words())
      .type_name("VIEW");
  add_style_to(command, particles);
  command
      .option(
          "--projection", [this](const std::string& text) { projection_ = projection_in(text); },
          "perspective, or orthographic: distant particles look as large as near ones (default: "
          "orthographic with --view, except with --view auto)")
      .words({scene_words::projections.begin(), scene_words::projections.end()})
      .type_name("NAME")
      .special();
  add_camera_to(command);
  command.section("");
}

void AutoSceneOptions::add_style_to(Command& command, ParticleOptions& particles) {
  // The first word of particle_style_words is the default.
  const auto of_particles = std::span(particle_style_words).subspan(1);
  std::vector<std::string> words(style_names.begin(), style_names.end());
  words.insert(words.end(), of_particles.begin(), of_particles.end());
  command
      .option(
          "--style",
          [this, &particles, words](const std::string& text) {
            const std::vector<std::string_view> known(words.begin(), words.end());
            for (const std::string_view word : split_at(',', text)) {
              const std::size_t place = known_place("style", word, known);
              if (place < style_names.size()) {
                style_ = static_cast<Style>(place);
              } else {
                styles_particles_ = true;
                particles.set_style(static_cast<ParticleStyle>(place - style_names.size() + 1));
              }
            }
          },
          "Surroundings of the particles. studio: a pale floor and soft light (default); "
          "publication: white with outlines; flat: white with outlines and light from all sides; "
          "night: dark, distant particles fade. Or shapes of the particles, also after --show: "
          "spheres, balls-and-sticks (as molecules of up to 500 atoms are drawn), sticks. Both: "
          "flat,sticks")
      .words(words, true)
      .type_name("STYLE")
      .in_order();
}

void AutoSceneOptions::add_camera_to(Command& command) {
  const auto number = [&](const char* name, NumberRange range, std::optional<double>& target,
                          const char* type, const char* help) {
    command
        .option(
            name, [range, &target](const std::string& text) { target = real_number(text, range); },
            help)
        .type_name(type)
        .special();
  };
  command
      .option(
          "--up", [this](const std::string& text) { turning_.up = up_from(text); },
          "Direction that points up in all views: x, y, z, -x, -y, -z, or three numbers such as "
          "0,1,1 (default: z)")
      .type_name("DIR")
      .special();
  number("--azimuth", azimuth_range, turning_.azimuth, "DEG",
         "Turn the camera to the right around the upward direction, from the side of --view or, "
         "without --view, from the front");
  number("--elevation", elevation_range, turning_.elevation, "DEG",
         "Raise the camera above the side of --view or, without --view, above the front");
  number(
      "--zoom", zoom_range, zoom_, "FACTOR",
      "Show the particles that many times larger; above about 1.2 the picture cuts some off, and "
      "labels may cover others");
}

void AutoSceneOptions::add_background_to(Command& command) {
  command
      .option(
          "--background", [this](const std::string& text) { background_ = color_from(text); },
          "Colour of the background, instead of floor or wall: white, black, grey or #RRGGBB "
          "(sRGB). It does not light the particles; in style studio, the light from the floor is "
          "missing")
      .type_name("COLOR")
      .group(particles_group)
      .special();
}

View AutoSceneOptions::named_view(std::string_view name) {
  const View view = view_from(name);
  names_axis_ = names_axis_ || place_in(view_axes, name).has_value();
  return view;
}

void AutoSceneOptions::check_unused(const std::string& file) const {
  std::string given;
  if (view_) given += " --view";
  if (style_ || styles_particles_) given += " --style";
  if (projection_) given += " --projection";
  if (turning_.up) given += " --up";
  if (turning_.azimuth) given += " --azimuth";
  if (turning_.elevation) given += " --elevation";
  if (zoom_) given += " --zoom";
  if (background_) given += " --background";
  if (given.empty()) return;
  throw InputError(
      given.substr(1) + ": " + printable(file, 4096) +
      " is not a particle file, and a scene file has its own camera, lights and materials: leave "
      "the option out, or change the scene file");
}

Viewing AutoSceneOptions::viewing() const {
  if (names_axis_ && turning_.up) {
    throw InputError(
        "--up turns the scene, so the name of an axis is no side of it: name a side with --view, "
        "such as front, or leave out --up");
  }
  Viewing viewing;
  viewing.view = view_.value_or(View::automatic);
  viewing.style = style_.value_or(Style::studio);
  viewing.projection = projection_;
  viewing.turning = turning_;
  viewing.zoom = zoom_.value_or(1);
  viewing.labels = labels_;
  viewing.whole_cell = whole_cell_ != nullptr && *whole_cell_;
  return viewing;
}

}  // namespace parray::commands
