#include <iostream>
#include <memory>

#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/printing.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/printable.h"
#include "common/input/particles/particles.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/trace/tracer.h"

namespace parray {
namespace {

using nlohmann::json;

struct ValidateCommand {
  std::string scene;
  RenderOptions render;
  bool as_json = false;
};

std::string format_of(const std::string& path, const SceneFile& file) {
  if (is_particle_file(path)) return "particles";
  return file.seed_format ? "seed" : "v1";
}

std::string format_text(const json& format) {
  if (format == "particles") return "particles, shown in a portrait";
  return format == "seed" ? "the seed program's" : "scene JSON v1";
}

/// Everything that the command says.
json facts_of(const ValidateCommand& command) {
  const SceneFile file = load_scene(command.scene, command.render);
  const Requirements needs = requirements_of(file.scene, usable_cpus());
  const ResolvedSettings resolved = resolve_settings(needs, file.settings);
  const RenderSettings& settings = resolved.settings;
  return {{"file", command.scene},
          {"format", format_of(command.scene, file)},
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

void print_facts(const json& f) {
  const bool any = f["spheres"] > 0;
  std::cout << printable(f["file"].get<std::string>(), 500) << ": valid\n"
            << list_text(
                   {{"format", format_text(f["format"])},
                    {"picture", count(f["width"]) + " x " + count(f["height"]) + " pixels, " +
                                    counted(f["samples_per_pixel"], "sample") + " each, depth " +
                                    count(f["max_depth"]) + ", seed " + count(f["seed"]) +
                                    ", sampler " + f["sampler"].get<std::string>()},
                    {"spheres", count(f["spheres"]) + ": " + count(f["diffuse"]) + " diffuse, " +
                                    count(f["metal"]) + " metal, " + count(f["dielectric"]) +
                                    " dielectric"},
                    {"left out", counted(f["duplicates_removed"], "duplicate")},
                    {"materials", count(f["materials"])},
                    {"features", joined(f["features"])},
                    {"radii",
                     any ? number(f["smallest_radius"]) + " to " + number(f["largest_radius"])
                         : "none"},
                    {"origin", origin_text(f["origin"])},
                    {"extent", number(f["extent"]) + " (largest coordinate or radius), " +
                                   number(f["spread"]) + " of the smallest radii"},
                    {"nearest", any ? number(f["nearest"]) + " from the eye; the picture is " +
                                          number(f["view_height"]) + " high there"
                                    : "none"},
                    {"rounding", "single precision moves surfaces by " +
                                     number(f["computed_shift"]) + " where computed, " +
                                     number(f["stored_shift"]) + " where only stored"},
                    {"precision", f["precision"].get<std::string>() + ": " +
                                      f["precision_reason"].get<std::string>()},
                    {"accelerator", f["accelerator"].get<std::string>() + ": " +
                                        f["accelerator_reason"].get<std::string>() + "; " +
                                        bytes_text(f["accelerator_bytes"])},
                    {"identity", "scene_sha256 " + f["scene_sha256"].get<std::string>()}});
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
      "validate", "Check a scene file and say what it requires and what auto picks for it");
  const auto options = std::make_shared<ValidateCommand>();
  add_scene(command, options->scene);
  add_json(command, options->as_json);
  options->render.add_to(command);
  command.example("parray validate scenes/glass.json", "what is in it, and what auto picks for it");
  command.on_chosen([options, &chosen] { chosen = [options] { return validate(*options); }; });
}

}  // namespace parray
