#include "cli/input/particles/beads.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include "cli/input/view/auto_scene.h"
#include "cli/output/picture/partial_file.h"
#include "common/scene/settings.h"
#include "tests/support/rooms.h"
#include "tests/support/temporary_directory.h"

/// Beads of coarse models in automatic scenes.
namespace parray {
namespace {

/// The automatic scene of a file with this text.
AutoScene scene_of_text(const std::string& name, const std::string& text,
                        ParticleSource source = {}) {
  const test::TemporaryDirectory directory;
  write_text_file(directory.path() / name, text);
  return auto_scene(directory.path() / name, std::move(source), auto_scene_settings());
}

/// A GRO file of lines "residue name x y z"; lengths in nm.
std::string gro(const std::vector<std::string>& names, const std::string& residue, double spacing) {
  std::string text = "beads\n" + std::to_string(names.size()) + "\n";
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::array<char, 100> line{};
    static_cast<void>(std::snprintf(line.data(), line.size(), "%5d%-5s%5s%5zu%8.3f%8.3f%8.3f\n", 1,
                                    residue.c_str(), names[i].c_str(), i + 1,
                                    spacing * static_cast<double>(i), 0.0, 0.0));
    text += line.data();
  }
  return text + "   9.00000   9.00000   9.00000\n";
}

/// The text of the note about beads. Empty: there is none.
std::string note_of_beads(const AutoScene& scene) {
  for (const ParticleNote& note : scene.file.particle_files.at(0).facts.notes) {
    if (note.key == "beads") return note.text;
  }
  return {};
}

const std::vector<std::string> lipid{"NC3", "PO4", "GL1", "GL2", "C1A", "C2A",
                                     "C3A", "C4A", "C1B", "C2B", "C3B", "C4B"};

}  // namespace

TEST_CASE("beads of a coarse model are coloured by name and touch, and one note says so") {
  const AutoScene scene = scene_of_text("lipid.gro", gro(lipid, "DPPC", 0.47));
  CHECK(scene.source.look.coloring.by == "atom");
  CHECK(scene.source.look.radius.rule == ParticleRadius::Rule::fixed);
  CHECK(scene.source.look.radius.value == doctest::Approx(4.7 / 2));
  REQUIRE(scene.file.legends.size() == 1);
  CHECK(scene.file.legends[0].entries.size() == 12);
  std::vector<std::string> keys;
  for (const ParticleNote& note : scene.file.particle_files[0].facts.notes) {
    if (note.key != "nanometres" && note.key != "converted_lengths") keys.push_back(note.key);
  }
  CHECK(std::ranges::count(keys, "beads") == 1);
  CHECK(std::ranges::count(keys, "guessed_elements") == 0);
}

TEST_CASE("atoms of molecules, and atoms that are far apart, are no beads") {
  const std::string atoms = gro({"N", "CA", "C", "O", "CB"}, "ALA", 0.15);
  const std::string argon = gro({"AR", "AR", "AR", "AR"}, "AR", 0.38);
  for (const std::string& text : {atoms, argon}) {
    const AutoScene scene = scene_of_text("a.gro", text);
    CHECK(scene.source.look.coloring.by.empty());
    CHECK(scene.source.look.radius.rule == ParticleRadius::Rule::by_element);
  }
}

TEST_CASE("a selection of atoms does not make beads of them") {
  const std::string atoms = gro({"N", "CA", "C", "N", "CA", "C", "N", "CA", "C"}, "ALA", 0.15);
  ParticleSource source;
  source.filter.select = "name CA";
  const AutoScene scene = scene_of_text("a.gro", atoms, source);
  CHECK(scene.source.look.radius.rule == ParticleRadius::Rule::by_element);
}

TEST_CASE("names of XYZ that are no elements are beads, too") {
  const AutoScene scene = scene_of_text("ab.xyz", "4\n\nA 0 0 0\nA 1 0 0\nA 2 0 0\nB 3 0 0\n");
  CHECK(scene.source.look.coloring.by == "type");
  CHECK(scene.source.look.radius.value == doctest::Approx(0.5));
}

TEST_CASE("rules that the user gives win over those of beads") {
  ParticleSource source;
  source.look.material = {ParticleMaterial::Rule::by_element, ""};
  source.look.radius = {ParticleRadius::Rule::fixed, 1};
  const AutoScene scene = scene_of_text("lipid.gro", gro(lipid, "DPPC", 0.47), source);
  CHECK(scene.source.look.coloring.by.empty());
  CHECK(scene.source.look.radius.value == 1);
}

TEST_CASE("each representation of beads gets the open rules that fit its style") {
  using Rule = ParticleRadius::Rule;
  ParticleSource source;
  ParticleLook balls{.style = ParticleStyle::balls_and_sticks};
  ParticleLook plain{.material = {ParticleMaterial::Rule::named, "plain"}};
  plain.radius = {Rule::fixed, 1};
  ParticleLook sticks{.style = ParticleStyle::sticks};
  source.shows = {{"all", {}}, {"index 0", balls}, {"index 1", plain}, {"index 2", sticks}};
  const AutoScene scene = scene_of_text("lipid.gro", gro(lipid, "DPPC", 0.47), source);
  const std::vector<Representation>& shows = scene.source.shows;
  CHECK(shows[0].look.radius.value == doctest::Approx(4.7 / 2));
  CHECK(shows[1].look.radius.value == doctest::Approx(4.7 / 4));
  CHECK(shows[1].look.coloring.by == "atom");
  CHECK(shows[2].look.radius.value == 1);
  CHECK(shows[2].look.coloring.empty());
  CHECK(shows[3].look.radius.rule != Rule::fixed);
  CHECK(note_of_beads(scene).ends_with(
      ": coloured by name, with the radius at which neighbours touch, or half of it"));
}

TEST_CASE("the note of beads names no radius that sticks replace") {
  ParticleSource source;
  source.look.style = ParticleStyle::sticks;
  const AutoScene scene = scene_of_text("lipid.gro", gro(lipid, "DPPC", 0.47), source);
  CHECK(note_of_beads(scene).ends_with("whose names are no elements: coloured by name"));
}

TEST_CASE("the typical distance is that of nearest neighbours, whatever the direction") {
  for (const Vec3d& step : {Vec3d{2, 0, 0}, Vec3d{0, 2, 0}, Vec3d{0, 0, 2}}) {
    std::vector<Vec3d> line;
    for (int i = 0; i < 5000; ++i) line.push_back(static_cast<double>(i) * step);
    CHECK(typical_distance(line) == 2);
  }
  std::vector<Vec3d> lattice;
  for (int i = 0; i < 1000; ++i) {
    const int row = i / 10 % 10;
    const int layer = i / 100;
    lattice.push_back({1.5 * (i % 10), 2.0 * row, 9.0 * layer});
  }
  CHECK(typical_distance(lattice) == 1.5);
  CHECK(typical_distance(std::vector<Vec3d>{{1, 2, 3}}) == 0);
}

}  // namespace parray
