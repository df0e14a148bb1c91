#include "cli/commands/particle_report.h"

#include <algorithm>
#include <array>

#include "cli/commands/printing.h"
#include "cli/input/particles/particle_summary.h"
#include "cli/output/text.h"
#include "common/base/printable.h"

namespace parray::commands {
namespace {

using nlohmann::json;
using Lines = std::vector<std::pair<std::string, std::string>>;

constexpr std::size_t most_names = 100;

json vector_json(const Vec3d& v) { return {v.x, v.y, v.z}; }

json optional_json(const auto& value) { return value ? json(*value) : json(); }

/// {name: count}, the commonest of many.
json counts_json(NameCounts counts) {
  if (counts.size() > most_names) {
    std::ranges::stable_sort(counts,
                             [](const auto& a, const auto& b) { return a.second > b.second; });
    counts.resize(most_names);
  }
  json map = json::object();
  for (const auto& [name, count] : counts) map[name] = count;
  return map;
}

json cell_json(const ParticleCell& cell) {
  const auto& [a, b, c] = cell.edges;
  return {{"origin", vector_json(cell.origin)},
          {"edges", {vector_json(a), vector_json(b), vector_json(c)}},
          {"lengths", vector_json(lengths_of(cell))},
          {"angles", vector_json(angles_of(cell))}};
}

void add_names(const ParticleSummary& summary, json& report) {
  if (!summary.elements.empty()) report["elements"] = counts_json(summary.elements);
  if (!summary.types.empty()) {
    report["types"] = counts_json(summary.types);
    report["type_count"] = summary.types.size();
  }
  if (summary.residues > 0) report["residues"] = summary.residues;
  if (!summary.residue_names.empty()) {
    report["residue_names"] = counts_json(summary.residue_names);
  }
  if (!summary.chains.empty()) {
    report["chains"] = counts_json(summary.chains);
    report["chain_count"] = summary.chains.size();
  }
}

std::string number(const json& value) {
  return value.is_null() ? "unknown" : number_cell(value.get<double>());
}

std::string vector_text(const json& v, const char* between) {
  return number(v[0]) + between + number(v[1]) + between + number(v[2]);
}

/// "C 12, H 30, ...": the commonest few.
std::string names_text(const json& counts) {
  constexpr std::size_t most = 12;
  std::vector<std::pair<std::string, std::uint64_t>> sorted;
  for (const auto& [name, count] : counts.items()) sorted.emplace_back(name, count);
  std::ranges::stable_sort(sorted,
                           [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string text;
  for (std::size_t i = 0; i < std::min(sorted.size(), most); ++i) {
    text +=
        (i == 0 ? "" : ", ") + printable(sorted[i].first) + " " + std::to_string(sorted[i].second);
  }
  return text + (sorted.size() > most ? ", ..." : "");
}

std::string composition_of(const json& report) {
  if (report.contains("elements")) return ": " + names_text(report["elements"]);
  if (report.contains("types")) return ", by type: " + names_text(report["types"]);
  return "";
}

/// "b_factor 3.1 to 40, 12 without"
std::string range_text(const json& range) {
  const std::uint64_t missing = range["missing"];
  return number(range["low"]) + " to " + number(range["high"]) +
         (missing > 0 ? ", not known of " + std::to_string(missing) : "");
}

std::string format_text(const json& report) {
  const std::string packing = report["packing"];
  return report["format"].get<std::string>() + (packing.empty() ? "" : ", packed by " + packing);
}

std::string frames_note(const json& report) {
  const std::string shown = "frame " + std::to_string(report["frame"].get<std::uint64_t>());
  const std::string time = report.contains("time") ? " at time " + number(report["time"]) : "";
  if (report["frames"].is_null()) return shown + time;
  return std::to_string(report["frames"].get<std::uint64_t>()) + ", of which " + shown + time +
         " is shown";
}

void add_molecules(const json& report, Lines& lines) {
  if (report.contains("residues")) {
    const json names = report.value("residue_names", json::object());
    lines.emplace_back("residues", std::to_string(report["residues"].get<std::uint64_t>()) +
                                       (names.empty() ? "" : ": " + names_text(names)));
  }
  if (report.contains("chains")) {
    lines.emplace_back("chains", std::to_string(report["chain_count"].get<std::uint64_t>()) + ": " +
                                     names_text(report["chains"]));
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
  lines.emplace_back("positions", text);
}

}  // namespace

json particle_report(const ParticleFile& file, const Particles& particles) {
  const ParticleFacts& facts = particles.facts;
  const ParticleSummary summary = summary_of(particles);
  json report = {{"file", name_of(file)},
                 {"format", facts.format},
                 {"packing", facts.packing},
                 {"particles", summary.count},
                 {"frames", optional_json(facts.frames)},
                 {"frame", facts.frame},
                 {"box", {{"low", vector_json(summary.low)}, {"high", vector_json(summary.high)}}},
                 {"properties", json::object()},
                 {"notes", notes_json(file.facts.notes)}};
  if (facts.time) report["time"] = *facts.time;
  add_names(summary, report);
  if (particles.cell) report["cell"] = cell_json(*particles.cell);
  for (const NumberRangeSeen& range : summary.numbers) {
    report["properties"][range.name] = {{"low", optional_json(range.low)},
                                        {"high", optional_json(range.high)},
                                        {"missing", range.missing}};
  }
  return report;
}

Lines particle_lines(const json& report) {
  Lines lines{{"particles",
               std::to_string(report["particles"].get<std::uint64_t>()) + composition_of(report)}};
  add_molecules(report, lines);
  if (!report["frames"].is_null() || report["frame"] > 0) {
    lines.emplace_back("frames", frames_note(report));
  }
  add_space(report, lines);
  for (const auto& [name, range] : report["properties"].items()) {
    lines.emplace_back(printable(name), range_text(range));
  }
  for (const json& note : report["notes"]) {
    lines.emplace_back("note", note_line(note));
  }
  return lines;
}

std::string note_line(const json& note) {
  return note_text({note["key"], note["count"], note["text"]});
}

std::string particle_line(const json& report) {
  return printable(report["file"].get<std::string>(), 500) + ": " + format_text(report) + ", " +
         counted(report["particles"], "particle") + composition_of(report);
}

}  // namespace parray::commands
