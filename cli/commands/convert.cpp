#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/options.h"
#include "cli/commands/printing.h"
#include "cli/input/formats/format_table.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/label_settings.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/auto_scene.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/text.h"
#include "cli/output/write_outputs.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"

namespace parray::commands {
namespace {

namespace fs = std::filesystem;

struct ConvertCommand {
  std::string in;
  std::string out;
  RenderOptions render;
  LabelOptions labels;
  bool expand = false;
  std::optional<Command> declared;  ///< the command that has these options
};

/// Returns the path of `file` relative to the folder of the scene file `scene`, so that both may
/// move together.
std::string reference_to(const fs::path& file, const fs::path& scene) {
  const fs::path folder = fs::weakly_canonical(fs::absolute(scene).parent_path());
  return fs::weakly_canonical(file).lexically_proximate(folder).generic_string();
}

/// Returns the path by which the scene names the file of particles. Throws InputError for standard
/// input.
std::string reference_in(const ConvertCommand& command, const PackedFile& file) {
  if (file.path().empty()) {
    throw InputError(
        "standard input has no name for a scene to refer to: add --expand, or save the input as "
        "a file");
  }
  return reference_to(file.path(), command.out);
}

/// Leaves out the labels that describe particle files, because the new scene refers to none. Keeps
/// the unit of a scale bar.
void drop_labels_of_files(SceneFile& scene) {
  LabelSettings& labels = scene.labels;
  labels.legend = labels.time_stamp = labels.cell = false;
  labels.legend_title.clear();
  if (!labels.scale_bar || !labels.unit.empty() || scene.particle_files.empty()) return;
  const std::string& unit = scene.particle_files.front().facts.length_unit;
  if (problem_with_label_text(unit, longest_unit).empty()) labels.unit = unit;
}

/// Returns the automatic scene of a file of particles.
SceneFile automatic(const ConvertCommand& command, PackedFile& file) {
  const std::string reference = command.expand ? "" : reference_in(command, file);
  AutoScene scene = automatic_scene(file, command.render, NamedFiles::anywhere);
  scene.file.labels = command.labels.fitting_in(scene.file);
  if (command.expand) {
    drop_labels_of_files(scene.file);
    return std::move(scene.file);
  }
  std::string& topology = scene.source.topology;
  if (!topology.empty()) topology = reference_to(topology, command.out);
  return with_reference(std::move(scene), reference);
}

/// Throws InputError if an option for particle files is given, as all options are.
void check_no_options(const ConvertCommand& command, const std::string& file) {
  command.render.particles().check_unused(file);
  command.render.auto_scene().check_unused(file);
  for (const GivenOption& given : command.declared->given_options()) {
    if (!given.name.starts_with("--")) continue;
    throw InputError(given.name + ": " + printable(file, 4096) +
                     " is not a particle file but a scene: leave out the option, or change the "
                     "scene file");
  }
}

SceneFile converted(const ConvertCommand& command) {
  PackedFile file = PackedFile::of_argument(command.in);
  if (particle_format_of(file) != nullptr) return automatic(command, file);
  check_no_options(command, file.name());
  SceneFile scene = read_scene_file(file, usable_cpus());
  expand_particles(scene, file.name(), usable_cpus());
  drop_labels_of_files(scene);
  return scene;
}

std::string contents_of(const SceneFile& scene) {
  std::string text = counted(scene.scene.spheres.size(), "sphere");
  if (const std::size_t capsules = scene.scene.capsules.size(); capsules > 0) {
    text += " and " + counted(capsules, "capsule");
  }
  for (const ParticleSource& source : scene.particles) {
    text += " and the particles of " + printable(source.file, 4096);
  }
  return text;
}

int convert(const ConvertCommand& command) {
  if (fs::path(command.out).extension() != ".json") {
    throw InputError(printable(command.out, 4096) +
                     ": the scene file to write needs a name that ends in .json: "
                     "parray convert IN OUT.json");
  }
  const std::string label = command.expand ? command.labels.first_given() : "";
  if (!label.empty()) {
    throw UsageError(label +
                     " and --expand exclude each other: the scene would not refer to the particle "
                     "file that labels describe: leave one of them out");
  }
  const OutputPaths outputs{.image = {}, .report = command.out};
  check_outputs(outputs, {command.in, command.render.particles().topology()});
  const SceneFile scene = converted(command);
  check_not_inputs(outputs, inputs_of(scene));
  print_notes(scene.particle_files);
  const DeferredInterrupts deferred;
  write_file(command.out, [&](std::ostream& out) { write_scene(out, scene, check_interrupted); });
  std::cout << "wrote " << command.out << ": " << contents_of(scene) << "\n";
  return 0;
}

}  // namespace

void add_convert(CommandLine& line) {
  Command command = line.command(
      "convert",
      "Make a scene file from a file of particles, or a self-contained scene file from "
      "another scene file");
  const auto options = std::make_shared<ConvertCommand>();
  add_scene(command, options->in, "IN");
  command.option("OUT.json", options->out, "Scene file to write")
      .required()
      .completes(Completes::files);
  options->render.add_scene_to(command);
  options->labels.add_to(command, nullptr, options->render);
  command
      .flag("--expand", options->expand,
            "Write all spheres, sticks and arrows, instead of a reference to the file")
      .group(particles_group);
  options->declared = command;
  command.example("parray convert scenes/particles/helix.pdb helix.json",
                  "writes a scene that refers to the file; you can edit its camera");
  command.example("parray convert scenes/particles/helix.pdb helix.json --expand --radius 0.5",
                  "writes the spheres, instead of a reference to the file");
  command.runs([options] { return convert(*options); });
}

}  // namespace parray::commands
