#include <algorithm>
#include <array>
#include <functional>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands/commands.h"
#include "cli/commands/loading.h"
#include "cli/commands/printing.h"
#include "cli/input/particles/json_types.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particle_summary.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/output/text.h"
#include "common/base/cpu_count.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"
#include "common/scene/requirements.h"
#include "common/scene/scene_bytes.h"
#include "common/scene/settings_fwd.h"
#include "common/trace/tracer.h"
#include "proto/settings_json.h"

namespace parray::commands {
namespace {

using nlohmann::json;
using Lines = std::vector<std::pair<std::string, std::string>>;

constexpr std::size_t most_names = 100;

/// Returns {name: count} with at most `most_names` entries, the most frequent ones.
json counts_json(NameCounts counts) {
  if (counts.size() > most_names) {
    std::ranges::stable_sort(counts, std::greater(), [](const auto& pair) { return pair.second; });
    counts.resize(most_names);
  }
  json map = json::object();
  for (const auto& [name, count] : counts) map[name] = count;
  return map;
}

json cell_json(const ParticleCell& cell) {
  return {{"origin", cell.origin},
          {"edges", cell.edges},
          {"lengths", lengths_of(cell)},
          {"angles", angles_of(cell)}};
}

void add_names(const ParticleSummary& summary, json& report) {
  if (!summary.elements.empty()) report["elements"] = counts_json(summary.elements);
  if (!summary.types.empty()) {
    report["types"] = counts_json(summary.types);
    report["type_count"] = summary.types.size();
  }
  if (summary.residues > 0) report["residues"] = summary.residues;
  if (!summary.residue_names.empty()) report["residue_names"] = counts_json(summary.residue_names);
  if (!summary.chains.empty()) {
    report["chains"] = counts_json(summary.chains);
    report["chain_count"] = summary.chains.size();
  }
}

std::string number(const json& value) {
  return value.is_null() ? "unknown" : number_cell(value.get<double>());
}

std::string count(const json& value) { return std::to_string(value.get<std::uint64_t>()); }

std::string vector_text(const json& v, const char* between) {
  return number(v[0]) + between + number(v[1]) + between + number(v[2]);
}

/// Returns the most frequent names: "C 12, H 30, ...".
std::string names_text(const json& counts) {
  constexpr std::size_t most = 12;
  std::vector<std::pair<std::string, std::uint64_t>> sorted;
  for (const auto& [name, count] : counts.items()) sorted.emplace_back(name, count);
  std::ranges::stable_sort(sorted, std::greater(), [](const auto& pair) { return pair.second; });
  std::vector<std::string> shown;
  for (const auto& [name, times] : std::span(sorted).first(std::min(sorted.size(), most))) {
    shown.push_back(printable(name) + " " + std::to_string(times));
  }
  return joined(shown, ", ") + (sorted.size() > most ? ", ..." : "");
}

std::string composition_of(const json& report) {
  if (report.contains("elements")) return ": " + names_text(report["elements"]);
  if (report.contains("types")) return ", by type: " + names_text(report["types"]);
  return "";
}

/// Returns the unit with a blank before it. Returns "" for an unknown unit.
std::string unit_text(const json& report) {
  const std::string unit = report.value("unit", "");
  return unit.empty() ? "" : " " + printable(unit);
}

/// Returns the range of a property: "3.1 to 40 m/s, missing for 12".
std::string range_text(const json& range) {
  const std::uint64_t missing = range["missing"];
  return number(range["low"]) + " to " + number(range["high"]) + unit_text(range) +
         (missing > 0 ? ", missing for " + std::to_string(missing) : "");
}

std::string particle_format(const json& report) {
  const std::string packing = report["packing"];
  std::string format = report["format"];
  if (packing.empty()) return format;
  return format + (packing.starts_with("tar") ? ", in " : ", compressed by ") + packing;
}

std::string frames_note(const json& report) {
  const std::string shown = "frame " + count(report["frame"]);
  const std::string time = report.contains("time") ? " at time " + number(report["time"]) : "";
  if (report["frames"].is_null()) return shown + time;
  return count(report["frames"]) + ", of which " + shown + time + " is shown";
}

void add_molecules(const json& report, Lines& lines) {
  if (report.contains("residues")) {
    const json names = report.value("residue_names", json::object());
    lines.emplace_back("residues",
                       count(report["residues"]) + (names.empty() ? "" : ": " + names_text(names)));
  }
  if (report.contains("chains")) {
    lines.emplace_back("chains",
                       count(report["chain_count"]) + ": " + names_text(report["chains"]));
  }
  if (report.contains("bonds")) {
    lines.emplace_back("bonds", count(report["bonds"]) + " in the file");
  }
}

void add_space(const json& report, Lines& lines) {
  if (report.contains("cell")) {
    const json& cell = report["cell"];
    lines.emplace_back("cell", vector_text(cell["lengths"], " x ") + ", angles " +
                                   vector_text(cell["angles"], ", ") + ", from " +
                                   vector_text(cell["origin"], ", "));
  }
  const json& box = report["box"];
  constexpr std::array<const char*, 3> axes{"x ", "y ", "z "};
  std::string text;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    text += (i == 0 ? "" : ", ") + std::string(axes.at(i)) + number(box["low"][i]) + " to " +
            number(box["high"][i]);
  }
  lines.emplace_back("positions", text + unit_text(report));
}

/// Returns the report of a file of particles as JSON; cli/REFERENCE.md lists the keys. `particles`:
/// the particles of the file, with all columns.
json particle_report(const ParticleFile& file, const Particles& particles) {
  const ParticleFacts& facts = particles.facts;
  const ParticleSummary summary = summary_of(particles);
  json report = {{"file", name_of(file)},
                 {"format", facts.format},
                 {"packing", facts.packing},
                 {"particles", summary.count},
                 {"frames", facts.frames},
                 {"frame", facts.frame},
                 {"box", {{"low", summary.low}, {"high", summary.high}}},
                 {"properties", json::object()},
                 {"notes", notes_json(file.facts.notes)}};
  if (facts.time) report["time"] = *facts.time;
  if (!facts.length_unit.empty()) report["unit"] = facts.length_unit;
  add_names(summary, report);
  if (!particles.bonds.empty()) report["bonds"] = particles.bonds.size();
  if (particles.cell) report["cell"] = cell_json(*particles.cell);
  for (const NumberRangeSeen& range : summary.numbers) {
    report["properties"][range.name] = {
        {"low", range.low}, {"high", range.high}, {"missing", range.missing}};
    if (!range.unit.empty()) report["properties"][range.name]["unit"] = range.unit;
  }
  return report;
}

/// Returns a note as text: "12 elements guessed from names".
std::string note_line(const json& note) {
  return note_text({note["key"], note["count"], note["text"]});
}

Lines particle_lines(const json& report) {
  Lines lines{{"particles", count(report["particles"]) + composition_of(report)}};
  add_molecules(report, lines);
  if (!report["frames"].is_null() || report["frame"] > 0) {
    lines.emplace_back("frames", frames_note(report));
  }
  add_space(report, lines);
  for (const auto& [name, range] : report["properties"].items()) {
    lines.emplace_back(printable(name), range_text(range));
  }
  for (const json& note : report["notes"]) lines.emplace_back("note", note_line(note));
  return lines;
}

std::string particle_line(const json& report) {
  return printable(report["file"].get<std::string>(), 500) + ": " + particle_format(report) + ", " +
         counted(report["particles"], "particle") + composition_of(report);
}

struct ValidateCommand {
  std::string scene;
  RenderOptions render;
  bool as_json = false;
};

/// Returns whether `file` is an automatic scene: its only file of particles is the opened file.
bool is_auto_scene(const PackedFile& opened, const SceneFile& file) {
  return file.particle_files.size() == 1 && file.particle_files[0].path == opened.path();
}

std::string format_of(const PackedFile& opened, const SceneFile& file) {
  if (is_auto_scene(opened, file)) return "particles";
  return file.seed_format ? "seed" : "v1";
}

std::string format_text(const json& facts) {
  const json& format = facts["format"];
  if (format == "particles") {
    return particle_format(facts["particle_files"][0]) + ": particles, in an automatic scene";
  }
  return format == "seed" ? "seed format ({\"sphere\": ...})" : "scene JSON v1";
}

/// Returns the reports of the scene's files of particles, with all of their columns.
json particle_files_of(PackedFile& opened, const SceneFile& file) {
  json list = json::array();
  const bool automatic = is_auto_scene(opened, file);
  const std::filesystem::path folder = automatic ? "" : opened.path().parent_path();
  const auto describe = [&](PackedFile& particles, const ParticleFile& shown) {
    ParticleRequest request = request_of(shown.source, folder, usable_cpus());
    request.all = true;
    list.push_back(particle_report(shown, read_particles(particles, request)));
  };
  for (const ParticleFile& shown : file.particle_files) {
    if (automatic) {
      describe(opened, shown);
    } else {
      PackedFile particles(shown.path);
      describe(particles, shown);
    }
  }
  return list;
}

json facts_of(const ValidateCommand& command) {
  PackedFile opened = PackedFile::of_argument(command.scene);
  const SceneFile file = load_scene(opened, command.render);
  const Requirements needs = requirements_of(file.scene, usable_cpus());
  const ResolvedSettings resolved = resolve_settings(needs, file.settings);
  const RenderSettings& settings = resolved.settings;
  json facts = settings_in_report(settings);
  facts.update(
      {{"file", opened.name()},
       {"format", format_of(opened, file)},
       {"particle_files", particle_files_of(opened, file)},
       {"spheres", needs.spheres},
       {"capsules", needs.capsules},
       {"surroundings", file.scenery},
       {"duplicates_removed", file.duplicates.count},
       {"diffuse", needs.diffuse},
       {"metal", needs.metal},
       {"dielectric", needs.dielectric},
       {"materials", file.scene.materials.size()},
       {"features", needs.features()},
       {"smallest_radius", needs.smallest_radius},
       {"largest_radius", needs.largest_radius},
       {"origin", needs.origin},
       {"extent", needs.extent},
       {"spread", needs.spread()},
       {"nearest", needs.nearest},
       {"view_height", needs.view_height},
       {"computed_shift", needs.computed_shift()},
       {"stored_shift", needs.stored_shift},
       {"precision_reason", resolved.precision_reason},
       {"accelerator_reason", resolved.accelerator_reason},
       {"accelerator_bytes", make_path_tracer(file.scene, settings)->accelerator()->bytes()},
       {"scene_sha256", scene_identity(file.scene)}});
  return facts;
}

std::string list_of(const json& names) {
  return names.empty() ? "none" : joined(names.get<std::vector<std::string>>(), ", ");
}

std::string origin_text(const json& origin) {
  if (origin == json{0.0, 0.0, 0.0}) return "0, 0, 0";
  return vector_text(origin, ", ") +
         " (positions are stored relative to this point, the scene's middle)";
}

/// Returns the lines about files of particles: the full report in an automatic scene, otherwise one
/// line per file.
Lines lines_of_particles(const json& f) {
  Lines lines;
  for (const json& file : f["particle_files"]) {
    if (f["format"] == "particles") return particle_lines(file);
    lines.emplace_back("particles", particle_line(file));
    for (const json& note : file["notes"]) lines.emplace_back("note", note_line(note));
  }
  return lines;
}

std::string shapes_text(const json& f) {
  const std::uint64_t around = f["surroundings"];
  const std::string surroundings =
      around == 0   ? ""
      : around == 1 ? "; one of them is surroundings"
                    : "; " + std::to_string(around) + " of them are surroundings";
  const std::string capsules =
      f["capsules"] > 0 ? " and " + counted(f["capsules"], "capsule") : std::string();
  return count(f["spheres"]) + capsules + ": " + count(f["diffuse"]) + " diffuse, " +
         count(f["metal"]) + " metal, " + count(f["dielectric"]) + " dielectric" + surroundings;
}

/// Returns the number of samples, or what else ends a render of the scene.
std::string accuracy_text(const json& f) {
  if (f["target_error"] > 0) return "up to an error of " + number(f["target_error"]);
  if (f["samples_per_pixel"] == limits::max_samples_per_pixel) return "until a limit";
  return counted(f["samples_per_pixel"], "sample") + " each";
}

Lines lines_of_scene(const json& f) {
  const bool any = f["spheres"] > 0 || f["capsules"] > 0;
  return {
      {"picture", count(f["width"]) + " x " + count(f["height"]) + " pixels, " + accuracy_text(f) +
                      ", depth " + count(f["max_depth"]) + ", seed " + count(f["seed"]) +
                      ", sampler " + f["sampler"].get<std::string>()},
      {"spheres", shapes_text(f)},
      {"left out", counted(f["duplicates_removed"], "duplicate")},
      {"materials", count(f["materials"])},
      {"features", list_of(f["features"])},
      {"radii", any ? number(f["smallest_radius"]) + " to " + number(f["largest_radius"]) : "none"},
      {"origin", origin_text(f["origin"])},
      {"extent", number(f["extent"]) + " (largest coordinate or radius), " + number(f["spread"]) +
                     " times the smallest radius"},
      {"nearest", any ? number(f["nearest"]) + " from the camera; the picture is " +
                            number(f["view_height"]) + " high there"
                      : "none"},
      {"rounding", "surfaces move by " + number(f["computed_shift"]) + " with precision f32, by " +
                       number(f["stored_shift"]) + " with mixed"},
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
  command.as_json ? print_json(facts) : print_facts(facts);
  return 0;
}

}  // namespace

void add_validate(CommandLine& line) {
  Command command = line.command(
      "validate",
      "Check a scene file or a file of particles; print its contents, requirements and automatic "
      "settings");
  const auto options = std::make_shared<ValidateCommand>();
  add_scene(command, options->scene);
  add_json(command, options->as_json);
  options->render.add_to(command);
  command.example("parray validate scenes/glass.json",
                  "prints the contents, and the automatic settings");
  command.example(
      "parray validate scenes/particles/helix.pdb",
      "prints atoms, residues, frames, the cell, and data that was guessed or left out");
  command.runs([options] { return validate(*options); });
}

}  // namespace parray::commands
