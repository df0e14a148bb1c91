#include "cli/commands/auto_scene_options.h"

#include <algorithm>
#include <vector>

#include "cli/commands/options.h"
#include "cli/input/scene_file/scene_fields.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray::commands {
namespace {

Projection projection_in(const std::string& text) {
  return static_cast<Projection>(known_place("projection", text, scene_words::projections));
}

template <std::size_t Count>
void append(std::vector<std::string>& words, const std::array<std::string_view, Count>& more) {
  words.insert(words.end(), more.begin(), more.end());
}

}  // namespace

std::vector<std::string> view_words() {
  std::vector<std::string> words;
  append(words, view_names);
  append(words, view_axes);
  return words;
}

void AutoSceneOptions::add_to(Command& command) {
  std::vector<std::string> styles;
  append(styles, style_names);
  std::vector<std::string> projections;
  append(projections, scene_words::projections);
  command
      .option(
          "--view", [this](const std::string& text) { view_ = view_from(text); },
          "Side of the view, or the axis that points at the viewer. z points up; from top and "
          "bottom y does (default: auto: molecules along their principal axes, flat groups face "
          "on, others obliquely from above)")
      .words(view_words())
      .type_name("VIEW")
      .group(particles_group);
  command
      .option(
          "--style", [this](const std::string& text) { style_ = style_from(text); },
          "Surroundings of the particles. studio: a pale floor and soft light (default); "
          "publication: white with outlines; flat: white with outlines and light from all sides; "
          "night: dark, distant particles fade")
      .words(styles)
      .type_name("STYLE")
      .group(particles_group);
  command
      .option(
          "--projection", [this](const std::string& text) { projection_ = projection_in(text); },
          "perspective, or orthographic: distant particles look as large as near ones (default: "
          "orthographic with --view, except with --view auto)")
      .words(projections)
      .type_name("NAME")
      .group(particles_group)
      .special();
}

void AutoSceneOptions::check_unused(const std::string& file) const {
  std::string given;
  if (view_) given += " --view";
  if (style_) given += " --style";
  if (projection_) given += " --projection";
  if (given.empty()) return;
  throw InputError(
      given.substr(1) + ": " + printable(file, 4096) +
      " is not a particle file, and a scene file has its own camera, lights and materials: leave "
      "the option out, or change the scene file");
}

Viewing AutoSceneOptions::viewing() const {
  Viewing viewing;
  viewing.view = view_.value_or(View::automatic);
  viewing.style = style_.value_or(Style::studio);
  viewing.projection = projection_;
  viewing.whole_cell = whole_cell_ != nullptr && *whole_cell_;
  return viewing;
}

void ViewOptions::add_to(Command& command) {
  command
      .on_off("--transparent", transparent_,
              "Make the background transparent. Alpha is the share of a pixel's camera rays that "
              "hit a sphere (default: the scene's, else off)")
      .group(output_group);
  command.renamed("--opaque", "--transparent off");
}

bool ViewOptions::transparent(bool of_scene) const {
  return transparent_.value_or(followed_.value_or(of_scene));
}

}  // namespace parray::commands
