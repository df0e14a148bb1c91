#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string_view>
#include <utility>

#include "cli/commands/commands.h"
#include "cli/commands/options.h"
#include "cli/output/delivery.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/image/partial_file.h"
#include "common/input/particles/expand.h"
#include "common/input/particles/portrait_scene.h"
#include "common/input/scene_writer.h"
#include "common/process/stop_signal.h"
#include "common/scene/scene_ranges.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

struct ConvertCommand {
  std::string in;
  std::string out;
  ParticleMaterial material;
  ParticleRadius radius;
  RenderOptions size;
  bool expand = false;

  [[nodiscard]] bool about_particles() const {
    return expand || size.has_size() || material.rule != ParticleMaterial::Rule::automatic ||
           radius.rule != ParticleRadius::Rule::automatic;
  }
};

constexpr const char* particles_group = "When IN is a file of particles";
constexpr std::array<std::string_view, 4> material_words{"by-element", "by-type", "column",
                                                         portrait_plain_name};

/// How a scene file at `scene` names `file`: relative, so that both may move together.
std::string reference_to(const fs::path& file, const fs::path& scene) {
  const fs::path folder = fs::weakly_canonical(fs::absolute(scene).parent_path());
  return fs::weakly_canonical(file).lexically_proximate(folder).generic_string();
}

SceneFile converted(const ConvertCommand& command) {
  if (is_particle_file(command.in)) {
    PortraitScene portrait = portrait_scene(command.in, command.material, command.radius,
                                            command.size.over(portrait_settings()), usable_cpus());
    if (command.expand) return std::move(portrait.file);
    return with_reference(std::move(portrait), reference_to(command.in, command.out));
  }
  if (command.about_particles()) {
    throw InputError(
        printable(command.in, 4096) +
        " is not a file of particles: --material, --radius, --width, --height and --expand are for "
        "those");
  }
  SceneFile scene = read_scene_file(command.in, usable_cpus());
  expand_particles(scene, command.in, usable_cpus());
  return scene;
}

std::string contents_of(const SceneFile& scene) {
  std::string text = counted(scene.scene.spheres.size(), "sphere");
  for (const ParticleSource& source : scene.particles) {
    text += " and the particles of " + printable(source.file, 4096);
  }
  return text;
}

int convert(const ConvertCommand& command) {
  if (fs::path(command.out).extension() != ".json") {
    throw InputError(printable(command.out, 4096) + ": the name of a scene ends in .json");
  }
  check_outputs({.image = {}, .report = command.out}, command.in);
  const SceneFile scene = converted(command);
  const DeferredInterrupts deferred;
  write_file(command.out, [&](std::ostream& out) { write_scene(out, scene, check_interrupted); });
  std::cout << "wrote " << command.out << ": " << contents_of(scene) << "\n";
  return 0;
}

void add_material(Command& command, ParticleMaterial& material) {
  command
      .option(
          "--material",
          [&material](const std::string& text) {
            material = particle_material_from(text);
            if (material.rule == ParticleMaterial::Rule::named && text != portrait_plain_name) {
              throw InputError("unknown material '" + printable(text) +
                               "': " + remedy_for_name(text, material_words));
            }
          },
          "Surface of the particles (default: column, else by-element, else by-type, else plain)")
      .words({"by-element", "by-type", "column", "plain"})
      .group(particles_group);
}

void add_radius(Command& command, ParticleRadius& radius) {
  command
      .option(
          "--radius",
          [&radius](const std::string& text) {
            const std::optional<ParticleRadius> word = particle_radius_from(text);
            radius = word ? *word
                          : ParticleRadius{ParticleRadius::Rule::fixed,
                                           real_number(text, ranges::length)};
          },
          "Their radius (default: column, else by-element, else half the mean spacing)")
      .words({"by-element", "column"})
      .type_name("R|by-element|column")
      .group(particles_group);
}

}  // namespace

void add_convert(CommandLine& line, Action& chosen) {
  Command command =
      line.command("convert", "Write a scene file from particles or from another scene file");
  const auto options = std::make_shared<ConvertCommand>();
  add_scene(command, options->in, "IN");
  command.option("OUT.json", options->out, "Scene file to write")
      .required()
      .completes(Completes::files);
  add_material(command, options->material);
  add_radius(command, options->radius);
  options->size.add_size_to(command, particles_group);
  command
      .flag("--expand", options->expand,
            "Write every particle as a sphere instead of the name of their file")
      .group(particles_group);
  command.example("parray convert scenes/particles/helix.pdb helix.json",
                  "a scene that refers to the file: change the view there");
  command.example("parray convert scenes/particles/helix.pdb helix.json --expand --radius 0.5",
                  "each particle as a sphere of its own");
  command.on_chosen([options, &chosen] { chosen = [options] { return convert(*options); }; });
}

}  // namespace parray
