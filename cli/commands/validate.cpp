#include <iostream>
#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/particle_report.h"
#include "cli/commands/printing.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/shown_particles.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/printable.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/trace/tracer.h"

namespace parray::commands {
namespace {

using nlohmann::json;
using Lines = std::vector<std::pair<std::string, std::string>>;

struct ValidateCommand {
  std::string scene;
  RenderOptions render;
  bool as_json = false;
};

/// A scene's own files of particles lie in its folder; a portrait's one is the file itself.
bool is_portrait(const PackedFile& opened, const SceneFile& file) {
  return file.particle_files.size() == 1 && file.particle_files[0].path == opened.path();
}

std::string format_of(const PackedFile& opened, const SceneFile& file) {
  if (is_portrait(opened, file)) return "particles";
  return file.seed_format ? "seed" : "v1";
}

std::string format_text(const json& facts) {
  const json& format = facts["format"];
  if (format == "particles") {
    const json& file = facts["particle_files"][0];
    const std::string packing = file["packing"];
    return file["format"].get<std::string>() + (packing.empty() ? "" : ", packed by " + packing) +
           ": particles, shown in a portrait";
  }
  return format == "seed" ? "the seed program's" : "scene JSON v1";
}

/// What the scene's files of particles hold, all of their columns, beside what it shows of them.
json particle_files_of(PackedFile& opened, const SceneFile& file) {
  json list = json::array();
  const bool portrait = is_portrait(opened, file);
  const std::filesystem::path folder = portrait ? "" : opened.path().parent_path();
  const auto describe = [&](PackedFile& particles, const ParticleFile& shown) {
    ParticleRequest request = request_of(shown.source, folder, usable_cpus());
    request.all = true;
    list.push_back(particle_report(shown, read_particles(particles, request)));
  };
  for (const ParticleFile& shown : file.particle_files) {
    if (portrait) {
      describe(opened, shown);
    } else {
      PackedFile particles(shown.path);
      describe(particles, shown);
    }
  }
  return list;
}

/// Everything that the command says.
json facts_of(const ValidateCommand& command) {
  PackedFile opened = PackedFile::of_argument(command.scene);
  const SceneFile file = load_scene(opened, command.render);
  const Requirements needs = requirements_of(file.scene, usable_cpus());
  const ResolvedSettings resolved = resolve_settings(needs, file.settings);
  const RenderSettings& settings = resolved.settings;
  return {{"file", opened.name()},
          {"format", format_of(opened, file)},
          {"particle_files", particle_files_of(opened, file)},
          {"width", settings.width},
          {"height", settings.height},
          {"samples_per_pixel", settings.samples_per_pixel},
          {"max_depth", settings.max_depth},
          {"seed", settings.seed},
          {"sampler", name_of(settings.sampler)},
          {"spheres", needs.spheres},
          {"duplicates_removed", file.duplicates.count},
          {"diffuse", needs.diffuse},
          {"metal", needs.metal},
          {"dielectric", needs.dielectric},
          {"materials", file.scene.materials.size()},
          {"features", needs.features()},
          {"smallest_radius", needs.smallest_radius},
          {"largest_radius", needs.largest_radius},
          {"origin", {needs.origin.x, needs.origin.y, needs.origin.z}},
          {"extent", needs.extent},
          {"spread", needs.spread()},
          {"nearest", needs.nearest},
          {"view_height", needs.view_height},
          {"computed_shift", needs.computed_shift()},
          {"stored_shift", needs.stored_shift},
          {"precision", name_of(settings.precision)},
          {"precision_reason", resolved.precision_reason},
          {"accelerator", name_of(settings.accelerator)},
          {"accelerator_reason", resolved.accelerator_reason},
          {"accelerator_bytes", make_path_tracer(file.scene, settings)->accelerator()->bytes()},
          {"scene_sha256", scene_identity(file.scene)}};
}

std::string joined(const json& names) {
  std::string text;
  for (const json& name : names) {
    text += (text.empty() ? "" : ", ") + name.get<std::string>();
  }
  return text.empty() ? "none" : text;
}

std::string number(const json& value) { return number_cell(value.get<double>()); }

std::string origin_text(const json& origin) {
  if (origin == json{0.0, 0.0, 0.0}) return "0, 0, 0";
  return number(origin[0]) + ", " + number(origin[1]) + ", " + number(origin[2]) +
         " (re-based: positions are rounded relative to the scene's middle)";
}

std::string count(const json& value) { return std::to_string(value.get<std::uint64_t>()); }

/// What files of particles hold: of a portrait's all of it, of others the main thing.
Lines lines_of_particles(const json& f) {
  Lines lines;
  for (const json& file : f["particle_files"]) {
    if (f["format"] == "particles") return particle_lines(file);
    lines.emplace_back("particles", particle_line(file));
    for (const json& note : file["notes"]) lines.emplace_back("note", note_line(note));
  }
  return lines;
}

std::string spheres_text(const json& f) {
  return count(f["spheres"]) + ": " + count(f["diffuse"]) + " diffuse, " + count(f["metal"]) +
         " metal, " + count(f["dielectric"]) + " dielectric" +
         (f["format"] == "particles" ? "; two of them are the portrait's ground and flag" : "");
}

Lines lines_of_scene(const json& f) {
  const bool any = f["spheres"] > 0;
  return {
      {"picture", count(f["width"]) + " x " + count(f["height"]) + " pixels, " +
                      counted(f["samples_per_pixel"], "sample") + " each, depth " +
                      count(f["max_depth"]) + ", seed " + count(f["seed"]) + ", sampler " +
                      f["sampler"].get<std::string>()},
      {"spheres", spheres_text(f)},
      {"left out", counted(f["duplicates_removed"], "duplicate")},
      {"materials", count(f["materials"])},
      {"features", joined(f["features"])},
      {"radii", any ? number(f["smallest_radius"]) + " to " + number(f["largest_radius"]) : "none"},
      {"origin", origin_text(f["origin"])},
      {"extent", number(f["extent"]) + " (largest coordinate or radius), " + number(f["spread"]) +
                     " of the smallest radii"},
      {"nearest", any ? number(f["nearest"]) + " from the eye; the picture is " +
                            number(f["view_height"]) + " high there"
                      : "none"},
      {"rounding", "single precision moves surfaces by " + number(f["computed_shift"]) +
                       " where computed, " + number(f["stored_shift"]) + " where only stored"},
      {"precision",
       f["precision"].get<std::string>() + ": " + f["precision_reason"].get<std::string>()},
      {"accelerator", f["accelerator"].get<std::string>() + ": " +
                          f["accelerator_reason"].get<std::string>() + "; " +
                          bytes_text(f["accelerator_bytes"])},
      {"identity", "scene_sha256 " + f["scene_sha256"].get<std::string>()}};
}

void print_facts(const json& f) {
  Lines lines{{"format", format_text(f)}};
  for (Lines more : {lines_of_particles(f), lines_of_scene(f)}) {
    lines.insert(lines.end(), more.begin(), more.end());
  }
  std::cout << printable(f["file"].get<std::string>(), 500) << ": valid\n" << list_text(lines);
}

int validate(const ValidateCommand& command) {
  const json facts = facts_of(command);
  if (command.as_json) {
    print_json(facts);
  } else {
    print_facts(facts);
  }
  return 0;
}

}  // namespace

void add_validate(CommandLine& line, Action& chosen) {
  Command command = line.command(
      "validate",
      "Check a scene file or a file of particles, and say what is in it, what it requires and what "
      "auto picks for it");
  const auto options = std::make_shared<ValidateCommand>();
  add_scene(command, options->scene);
  add_json(command, options->as_json);
  options->render.add_to(command);
  command.example("parray validate scenes/glass.json", "what is in it, and what auto picks for it");
  command.example("parray validate scenes/particles/helix.pdb",
                  "atoms, residues, frames, the cell, and what was guessed or left out");
  command.on_chosen([options, &chosen] { chosen = [options] { return validate(*options); }; });
}

}  // namespace parray::commands
