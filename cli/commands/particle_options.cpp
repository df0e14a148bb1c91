#include "cli/commands/particle_options.h"

#include <array>
#include <string_view>
#include <utility>

#include "cli/commands/options.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/input/portrait/portrait_scene.h"
#include "common/scene/limits.h"
#include "common/scene/scene_ranges.h"

namespace parray {
namespace {

using MaterialRule = ParticleMaterial::Rule;
using RadiusRule = ParticleRadius::Rule;

ParticleMaterial material_in(const std::string& text) {
  static constexpr std::array<std::string_view, 4> words{"by-element", "by-type", "column",
                                                         portrait_plain_name};
  ParticleMaterial material = particle_material_from(text);
  if (material.rule == MaterialRule::named && text != portrait_plain_name) {
    throw InputError("unknown material '" + printable(text) + "': " + remedy_for_name(text, words));
  }
  return material;
}

ParticleRadius radius_in(const std::string& text) {
  const std::optional<ParticleRadius> word = particle_radius_from(text);
  return word ? *word : ParticleRadius{RadiusRule::fixed, real_number(text, ranges::length)};
}

}  // namespace

void ParticleOptions::add_to(Command& command) {
  add_whole_number(
      command, "--frame", 0, limits::max_frame,
      [this](std::uint64_t number) {
        frame_ = {number, false};
      },
      "Which of the file's frames, from 0 (default: the first)")
      .group(particles_group);
  command
      .option(
          "--material", [this](const std::string& text) { material_ = material_in(text); },
          "Surface of the particles (default: column, else by-element, else by-type, else plain)")
      .words({"by-element", "by-type", "column", "plain"})
      .group(particles_group);
  command
      .option(
          "--radius", [this](const std::string& text) { radius_ = radius_in(text); },
          "Their radius (default: column, else by-element, else half the mean spacing)")
      .words({"by-element", "column"})
      .type_name("R|by-element|column")
      .group(particles_group);
}

void ParticleOptions::check_unused(const std::string& file) const {
  std::string given;
  if (frame_) given += " --frame";
  if (material_.rule != MaterialRule::automatic) given += " --material";
  if (radius_.rule != RadiusRule::automatic) given += " --radius";
  if (given.empty()) return;
  throw InputError(given.substr(1) + ": " + printable(file, 4096) +
                   " is not a file of particles: write them into its section particles");
}

ParticleSource ParticleOptions::over(ParticleSource source) const {
  if (frame_) source.frame = frame_;
  if (material_.rule != MaterialRule::automatic) source.material = material_;
  if (radius_.rule != RadiusRule::automatic) source.radius = radius_;
  return source;
}

}  // namespace parray
