#include "cli/input/particles/cell_operations.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <sstream>
#include <string>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/scene_file/scene_file.h"
#include "cli/input/view/auto_scene.h"
#include "common/base/error.h"
#include "common/scene/settings.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::message_of;
using test::ParticleFiles;

const std::string copper_cell =
    "4\nLattice=\"3.615 0 0 0 3.615 0 0 0 3.615\" Properties=species:S:1:pos:R:3\n"
    "Cu 0 0 0\nCu 1.8075 1.8075 0\nCu 1.8075 0 1.8075\nCu 0 1.8075 1.8075\n";

const std::string salt_cif =
    "data_salt\n_cell_length_a 5.64\n_cell_length_b 5.64\n_cell_length_c 5.64\n"
    "_symmetry_space_group_name_H-M 'F m -3 m'\nloop_\n_atom_site_label\n"
    "_atom_site_type_symbol\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\n"
    "Na1 Na 0 0 0\nCl1 Cl 0.5 0.5 0.5\n";

const std::string boxed_protein =
    "CRYST1   20.000   20.000   20.000  90.00  90.00  90.00 P 1           1\n"
    "ATOM      1  N   ALA A   1       0.000   0.000   0.000  1.00  0.00           N\n"
    "ATOM      2  CA  ALA A   1       1.450   0.000   0.000  1.00  0.00           C\n";

/// Returns the automatic scene of a file, with full radii also for molecules.
AutoScene scene_of(const std::filesystem::path& file, ParticleSource source = {}) {
  source.look.style = ParticleStyle::spheres;
  return auto_scene(file, source, auto_scene_settings());
}

/// Returns the radii of the particles of a scene.
std::vector<double> radii_of(const AutoScene& scene) {
  std::vector<double> radii;
  for (std::size_t i = scene.file.scenery; i < scene.file.scene.spheres.size(); ++i) {
    radii.push_back(scene.file.scene.spheres[i].radius);
  }
  return radii;
}

std::string cell_of(double edge, std::size_t atoms) {
  std::string text = std::to_string(atoms) + "\nLattice=\"" + std::to_string(edge) + " 0 0 0 " +
                     std::to_string(edge) + " 0 0 0 " + std::to_string(edge) +
                     "\" Properties=species:S:1:pos:R:3\n";
  for (std::size_t i = 0; i < atoms; ++i) {
    text += "Ar " + std::to_string(static_cast<double>(i) * edge / static_cast<double>(atoms)) +
            " 0 0\n";
  }
  return text;
}

/// Returns the error of an automatic scene, without the directory.
std::string refusal(const std::filesystem::path& file, const ParticleSource& source) {
  const std::string message = message_of<InputError>([&] { (void)scene_of(file, source); });
  return message.substr(message.find(file.filename().string()));
}

}  // namespace

TEST_CASE("a unit cell of copper has its fourteen atoms, which touch, and its edges") {
  const ParticleFiles files;
  const AutoScene copper = scene_of(files.write("cu.xyz", copper_cell));
  CHECK(radii_of(copper) == std::vector<double>(14, 1.28));
  CHECK(copper.file.labels.cell);
  CHECK(copper.source.cell.crystal == true);
  CHECK(copper.source.look.radius.rule == ParticleRadius::Rule::covalent);
  const auto& notes = copper.file.particle_files.front().facts.notes;
  const auto note = std::ranges::find(notes, "boundary_copies", &ParticleNote::key);
  REQUIRE(note != notes.end());
  CHECK(note->count == 10);
}

TEST_CASE("salt from a CIF has sodium on all corners and faces, and chlorine on all edges") {
  const ParticleFiles files;
  const AutoScene salt = scene_of(files.write("salt.cif", salt_cif));
  const std::vector<double> radii = radii_of(salt);
  CHECK(std::ranges::count(radii, crystal_radius(11)) == 14);
  CHECK(std::ranges::count(radii, crystal_radius(17)) == 13);
}

TEST_CASE("3 x 3 x 3 cells of copper share the atoms on their faces") {
  const ParticleFiles files;
  ParticleSource source;
  source.cell.replicate = replicas_from("3x3x3");
  const AutoScene copper = scene_of(files.write("cu.xyz", copper_cell), source);
  CHECK(radii_of(copper).size() == 7 * 7 * 7 / 2 + 1);  // every other point of a grid
  CHECK(copper.file.cell->edges[0].x == doctest::Approx(3 * 3.615));
}

TEST_CASE("proteins, boxes with residues and melts are no crystals") {
  const ParticleFiles files;
  const AutoScene protein = scene_of(files.write("p.pdb", boxed_protein));
  CHECK(radii_of(protein) == std::vector<double>{element(7).radius, element(6).radius});
  CHECK_FALSE(protein.file.labels.cell);
  const AutoScene box = scene_of(files.write(
      "w.gro", "water\n1\n    1SOL     OW    1   0.000   0.000   0.000\n 1.0 1.0 1.0\n"));
  CHECK(radii_of(box) == std::vector<double>{element(8).radius});
  CHECK(radii_of(scene_of(files.write("melt.xyz", cell_of(60, 501)))) ==
        std::vector<double>(501, element(18).radius));
  CHECK(radii_of(scene_of(files.write("molecule.xyz", "1\n\nC 0 0 0\n"))) ==
        std::vector<double>{element(6).radius});
  CHECK(radii_of(scene_of(files.write("cell.xyz", cell_of(60, 500)))).size() > 500);
}

TEST_CASE("a cell that the file says is not periodic makes no crystal") {
  const ParticleFiles files;
  std::string open = copper_cell;
  open.replace(open.find(" Properties"), 0, " pbc=\"F F F\"");
  CHECK(radii_of(scene_of(files.write("cu.xyz", open))) ==
        std::vector<double>(4, element(29).radius));
  const char* const dump =
      "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS %\n0 8\n0 8\n0 8\n"
      "ITEM: ATOMS element x y z\nC 0 0 0\n";
  const auto spheres = [&](const std::string& boundaries) {
    std::string text = dump;
    text.replace(text.find('%'), 1, boundaries);
    return radii_of(scene_of(files.write("a.dump", text))).size();
  };
  CHECK(spheres("pp pp pp") == 8);
  CHECK(spheres("pp pp ff") == 4);
  CHECK(spheres("ss mm ff") == 1);
}

TEST_CASE("the user's radius and choice win over those of crystals") {
  const ParticleFiles files;
  const auto file = files.write("cu.xyz", copper_cell);
  ParticleSource source;
  source.look.radius = particle_radius_from("0.5");
  CHECK(radii_of(scene_of(file, source)) == std::vector<double>(14, 0.5));
  source.look.radius = particle_radius_from("by-element");
  CHECK(radii_of(scene_of(file, source)) == std::vector<double>(14, element(29).radius));
  ParticleSource off;
  off.cell.crystal = false;
  CHECK(radii_of(scene_of(file, off)) == std::vector<double>(4, element(29).radius));
  ParticleSource on;
  on.cell.crystal = true;
  const auto protein = files.write("p.pdb", boxed_protein);
  CHECK(radii_of(scene_of(protein, on)).size() == 8 + 4);
  CHECK(radii_of(scene_of(protein, on)).front() == covalent_radius(7));
  ParticleSource covalent;
  covalent.look.radius = particle_radius_from("covalent");
  CHECK(radii_of(scene_of(files.write("c.xyz", "1\n\nC 0 0 0\n"), covalent)) ==
        std::vector<double>{covalent_radius(6)});
}

TEST_CASE("operations without a cell, and too many copies, name their option") {
  const ParticleFiles files;
  const auto molecule = files.write("m.xyz", "1\n\nC 0 0 0\n");
  ParticleSource source;
  source.cell.wrap = true;
  CHECK(refusal(molecule, source) ==
        "m.xyz: --wrap: the file has no box and no cell: leave it out");
  source.cell.whole = true;
  CHECK(refusal(molecule, source) ==
        "m.xyz: --whole: the file has no box and no cell: leave it out");
  source.cell.replicate = replicas_from("2x1x1");
  CHECK(refusal(molecule, source) ==
        "m.xyz: --replicate: the file has no box and no cell: leave it out");
  ParticleSource crystal;
  crystal.cell.crystal = true;
  CHECK(refusal(molecule, crystal) ==
        "m.xyz: --crystal: the file has no box and no cell: leave it out");
  const auto copper = files.write("cu.xyz", copper_cell);
  ParticleSource many;
  many.cell.replicate = replicas_from("3000x3000x3000");
  CHECK(refusal(copper, many) ==
        "cu.xyz: --replicate: 3000x3000x3000 copies of 4 particles are more than 100000000 "
        "spheres: use fewer copies");
  const auto wide = files.write("wide.xyz", cell_of(1e14, 1));
  ParticleSource far;
  far.cell.replicate = replicas_from("30x1x1");
  CHECK(refusal(wide, far) ==
        "wide.xyz: --replicate: a coordinate would be beyond 1e15: use fewer copies or a larger "
        "unit of length");
}

TEST_CASE("the selection of center must select particles that exist") {
  const ParticleFiles files;
  const auto copper = files.write("cu.xyz", copper_cell);
  ParticleSource source;
  source.cell.center = "element Au";
  CHECK(refusal(copper, source) ==
        "cu.xyz: --center: no particle is selected: there are elements Cu");
  source.cell.center = "charge > 0";
  CHECK(refusal(copper, source).starts_with("cu.xyz: --center: "));
}

TEST_CASE("operations come in their order, before the selection") {
  const ParticleFiles files;
  const auto file =
      files.write("w.xyz",
                  "3\nLattice=\"10 0 0 0 10 0 0 0 10\" Properties=species:S:1:pos:R:3\n"
                  "O 9.8 1 1\nH 0.6 1 1\nH 9.5 1.9 1\n");
  ParticleSource source;
  source.cell.crystal = false;
  source.cell.whole = true;
  source.cell.center = "element O";
  source.cell.replicate = replicas_from("2x1x1");
  source.filter.select = "x > 10";
  PackedFile packed(file);
  const Particles particles = selected(read_particles(packed, request_of(source, {})), packed,
                                       source, request_of(source, {}));
  REQUIRE(particles.count() == 3);
  CHECK(length(particles.positions[0] - Vec3d{15, 5, 5}) < 1e-9);
  CHECK(length(particles.positions[1] - Vec3d{15.8, 5, 5}) < 1e-9);
}

TEST_CASE("scenes draw crystals only if they say so, and converted scenes do") {
  const ParticleFiles files;
  const auto copper = files.write("cu.xyz", copper_cell);
  const auto spheres = [&](const std::string& members) {
    const auto path = files.write(
        "scene.json",
        R"({"version": 1, "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
 "particles": [{"file": "cu.xyz")" +
            members + "}]}");
    SceneFile scene = read_scene_file(path);
    expand_particles(scene, path);
    return scene.scene.spheres;
  };
  CHECK(spheres("").size() == 4);
  CHECK(spheres("").front().radius == element(29).radius);
  CHECK(spheres(R"(, "crystal": false)").size() == 4);
  CHECK(spheres(R"(, "crystal": true)").size() == 14);
  CHECK(spheres(R"(, "crystal": true)").front().radius == 1.28);
  CHECK(spheres(R"(, "replicate": "2x2x1", "wrap": true)").size() == 16);

  ParticleSource source;
  source.cell.replicate = replicas_from("2x1x1");
  source.cell.center = "element Cu";
  source.cell.whole = true;
  std::ostringstream text;
  write_scene(text, with_reference(scene_of(copper, source), "cu.xyz"), [] {});
  std::istringstream in(text.str());
  const SceneFile again = read_scene(in, "s.json");
  source.cell.crystal = true;
  CHECK(again.particles.front().cell == source.cell);
  CHECK(again.labels.cell);
}

TEST_CASE("errors of cell operations in a scene name the line of the member") {
  const ParticleFiles files;
  (void)files.write("m.xyz", "1\n\nC 0 0 0\n");
  const auto error = [&](const std::string& member) {
    const auto path = files.write(
        "scene.json",
        "{\"version\": 1, \"camera\": {\"look_from\": [0, 0, 9], \"look_at\": [0, 0, 0], \"vfov\": "
        "40},\n\"particles\": [{\"file\": \"m.xyz\",\n" +
            member + "}]}");
    const std::string message = message_of<InputError>([&] {
      SceneFile scene = read_scene_file(path);
      expand_particles(scene, path);
    });
    return message.substr(message.find("scene.json:") + 11);
  };
  CHECK(error(R"("replicate": "2x2x2")") ==
        "3: /particles/0/replicate: the file has no box and no cell: leave it out");
  CHECK(error(R"("replicate": "2x2")").starts_with("3: /particles/0/replicate: '2x2' is not a"));
  CHECK(error(R"("center": "")").starts_with("3: /particles/0/center: the selection is empty"));
}

}  // namespace parray
