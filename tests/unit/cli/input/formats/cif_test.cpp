#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cli/input/formats/crystal.h"
#include "cli/input/particles/particle_summary.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::Elements;
using test::everything;
using test::ParticleFiles;
using test::Xs;
using test::xs_of;

const std::string no_coordinates =
    "no atom has three coordinates: replace each ? and . of the coordinates by a number";

/// mmCIF whose loop has these items and values.
std::string cif(const std::string& items, const std::string& values) {
  std::string text = "data_1ABC\n_entry.id 1ABC\nloop_\n";
  for (std::size_t at = 0; at < items.size();) {
    const std::size_t end = std::min(items.find(' ', at), items.size());
    text += "_atom_site." + items.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return text + values + "\n#\n";
}

Particles read_cif(const ParticleFiles& files, const std::string& text) {
  return read_particles(files.write("a.cif", text), everything);
}

const std::string crystal_cell =
    "_cell_length_a 4.0(1)\n_cell_length_b 5\n_cell_length_c 6\n_cell_angle_alpha 90\n"
    "_cell_angle_beta 90\n_cell_angle_gamma 90\n";

/// Sites of a crystal: label, symbol, x, y, z, occupancy, group of disorder.
std::string sites(const std::string& rows) {
  return "loop_\n_atom_site_label\n_atom_site_type_symbol\n_atom_site_fract_x\n_atom_site_fract_y\n"
         "_atom_site_fract_z\n_atom_site_occupancy\n_atom_site_disorder_group\n" +
         rows;
}

}  // namespace

TEST_CASE("mmCIF: the atoms of the first model are read from their loop") {
  const ParticleFiles files;
  const std::string items =
      "group_PDB id type_symbol label_alt_id label_atom_id label_comp_id "
      "label_seq_id auth_asym_id Cartn_x Cartn_y Cartn_z occupancy "
      "pdbx_PDB_model_num";
  const Particles particles = files.read("a.cif", cif(items,
                                                      "ATOM 1 C . CA ALA 1 A 1.5 2(1) 3 1 1\n"
                                                      "ATOM 2 O A \"O5'\" ALA 1 A 4 5 6 0.3 1\n"
                                                      "ATOM 3 O B \"O5'\" ALA 1 A 7 8 9 0.7 1\n"
                                                      "HETATM 4 FE ? FE HEM . B -1 -2 -3 . 1\n"
                                                      "ATOM 1 C . CA ALA 1 A 9 9 9 1 2"));
  CHECK(particles.positions == std::vector<Vec3d>{{1.5, 2, 3}, {7, 8, 9}, {-1, -2, -3}});
  CHECK(particles.elements == Elements{6, 8, 26});
  CHECK(particles.types.names == std::vector<std::string>{"C", "O", "Fe"});
}

TEST_CASE("mmCIF: a single atom outside a loop is read") {
  const ParticleFiles files;
  const std::string text =
      "data_x\n_cell.length_a 10\n_atom_site.Cartn_x 1\n_atom_site.cartn_Y 2\n"
      "_atom_site.CARTN_Z 3\n_atom_site.type_symbol 'Na'\n";
  for (const char* end : {"", "_cell.length_b 1\n", "loop_\n_a.b\n1 2 3\n", "data_y\n"}) {
    CAPTURE(end);
    const Particles particles = files.read("a.cif", text + end);
    CHECK(particles.positions == std::vector<Vec3d>{{1, 2, 3}});
    CHECK(particles.elements == Elements{11});
  }
}

TEST_CASE("mmCIF: text fields, comments, other loops and later blocks are skipped") {
  const ParticleFiles files;
  const std::string own = cif("type_symbol Cartn_x Cartn_y Cartn_z", "C 1 2 3");
  const std::string before =
      "# about\ndata_first\nloop_\n_a.b\n_a.c\n1 'two words'\n;text\n"
      "loop_ _atom_site.Cartn_x 9\n;\n4\n_d.e 5\n";
  CHECK(xs_of(files.read("a.cif", before + own)) == Xs{1});
  CHECK(xs_of(files.read("a.cif", own + cif("Cartn_x Cartn_y Cartn_z", "7 8 9"))) == Xs{1});
}

TEST_CASE(
    "CIF of a crystal: each operation adds an image in the cell, except on special positions") {
  const ParticleFiles files;
  const std::string operations = "loop_\n_symmetry_equiv_pos_as_xyz\n'x,y,z'\n'-x, -y, 1/2+z'\n";
  const Particles particles = read_cif(
      files, "data_a\n" + crystal_cell + operations +
                 sites("Ca1 Ca2+ 0.25 0.5(1) 0.125 1 .\nO1 O2- 0 0 -0.25 1 .\nC1 ? 0 0 0 1 .\n"));
  REQUIRE(particles.count() == 6);
  CHECK(particles.elements == Elements{20, 20, 8, 8, 6, 6});
  CHECK(particles.positions[0] == Vec3d{1, 2.5, 0.75});
  CHECK(particles.positions[1] == Vec3d{3, 2.5, 3.75});
  CHECK(particles.positions[2] == Vec3d{0, 0, 4.5});
  CHECK(particles.positions[3] == Vec3d{0, 0, 1.5});
  CHECK(particles.atom_names.names == std::vector<std::string>{"Ca1", "O1", "C1"});
  REQUIRE(particles.cell.has_value());
  CHECK(particles.cell->edges[2] == Vec3d{0, 0, 6});
  // On a mirror plane both operations say the same.
  CHECK(read_cif(files, "data_a\n" + crystal_cell +
                            "loop_\n_space_group_symop_operation_xyz\nx,y,z\n-x,y,z\n" +
                            sites("C1 C 0.5 0.1 0.2 1 .\n"))
            .count() == 1);
}

TEST_CASE("CIF of a crystal: without operations, the name of the space group gives them") {
  const ParticleFiles files;
  const std::string name = "data_a\n_symmetry_space_group_name_H-M 'F m -3 m'\n" + crystal_cell;
  CHECK(read_cif(files, name + sites("Na1 Na 0 0 0 1 .\nCl1 Cl 0.5 0.5 0.5 1 .\n")).count() == 8);
  CHECK(read_cif(files, "data_a\n_symmetry_Int_Tables_number 225\n" + crystal_cell +
                            sites("Na1 Na 0 0 0 1 .\n"))
            .count() == 4);
  const Particles unknown =
      read_cif(files, "data_a\n" + crystal_cell + sites("Na1 Na 0 0 0 1 .\n"));
  CHECK(unknown.count() == 1);
  CHECK(test::note(unknown, "unknown_symmetry") == 1);
}

TEST_CASE(
    "CIF of a crystal: one of several disordered or shared sites is shown and a note counts the "
    "others") {
  const ParticleFiles files;
  const std::string text =
      "data_a\n_symmetry_space_group_name_H-M 'P -1'\n" + crystal_cell +
      sites(
          "C1 C 0.1 0.1 0.1 1 .\nC2A C 0.2 0.2 0.2 0.4 1\nC2B C 0.25 0.2 0.2 0.6 2\n"
          "Mg1 Mg 0.3 0.3 0.3 0.3 .\nFe1 Fe 0.3 0.3 0.3 0.7 .\nO1 O ? ? ? 1 .\n");
  const Particles particles = read_cif(files, text);
  CHECK(particles.elements == Elements{6, 6, 6, 6, 26, 26});
  CHECK(particles.positions[2].x == 1);
  CHECK(test::note(particles, "alternatives") == 4);
  CHECK(test::note(particles, "partial_occupancy") == 4);
  CHECK(test::note(particles, "unplaced") == 1);
  CHECK(files.message("a.cif", "data_a\n" + crystal_cell + sites("C1 C ? 0 0 1 .\n")) ==
        "a.cif:16: " + no_coordinates);
  ParticleRequest all;
  all.alternatives = {AlternativeChoice::Rule::all};
  CHECK(read_particles(files.write("a.cif", text), all).count() == 10);
}

TEST_CASE("CIF of a crystal: a missing cell and an invalid operation are refused") {
  const ParticleFiles files;
  CHECK(files.message("a.cif", "data_a\n" + sites("C1 C 0 0 0 1 .\n")) ==
        "a.cif:10: the coordinates are fractions, but the file has no valid cell: add or correct "
        "_cell_length_a, _cell_length_b, _cell_length_c and the angles");
  CHECK(files.message("a.cif", "data_a\n" + crystal_cell + "_symmetry_equiv_pos_as_xyz 'x,y'\n" +
                                   sites("C1 C 0 0 0 1 .\n")) ==
        "a.cif:17: 'x,y' is not a symmetry operation: write an operation such as 'x, y+1/2, -z'");
}

TEST_CASE("symmetry operations: signs, fractions, decimals and factors in any order") {
  using Row = std::array<double, 12>;
  CHECK(symmetry_operation_in("x,y,z") == Row{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  CHECK(symmetry_operation_in("-Y, X-Y ,1/2+z") == Row{0, -1, 0, 0, 1, -1, 0, 0, 0, 0, 1, 0.5});
  CHECK(symmetry_operation_in("x+.25,-1/4-y,2*z-x/2") ==
        Row{1, 0, 0, 0.25, 0, -1, 0, -0.25, -0.5, 0, 2, 0});
  for (const char* text : {"", "x,y", "x,y,z,x", "x,,z", "x,y,w", "x,y,1/0", "x,y,z+", "x,y,2*"}) {
    CAPTURE(text);
    CHECK(!symmetry_operation_in(text));
  }
}

TEST_CASE(
    "CIF of a component: ideal coordinates if all atoms have them, otherwise those of the model") {
  const ParticleFiles files;
  const std::string head =
      "data_ABC\nloop_\n_chem_comp_atom.comp_id\n_chem_comp_atom.atom_id\n"
      "_chem_comp_atom.type_symbol\n_chem_comp_atom.charge\n_chem_comp_atom.model_Cartn_x\n"
      "_chem_comp_atom.model_Cartn_y\n_chem_comp_atom.model_Cartn_z\n"
      "_chem_comp_atom.pdbx_model_Cartn_x_ideal\n_chem_comp_atom.pdbx_model_Cartn_y_ideal\n"
      "_chem_comp_atom.pdbx_model_Cartn_z_ideal\n";
  const Particles ideal =
      read_cif(files, head + "ABC C1 C 0 1 1 1 5 5 5\nABC \"O'\" O -1 2 2 2 6 6 6\n");
  CHECK(xs_of(ideal) == Xs{5, 6});
  CHECK(ideal.elements == Elements{6, 8});
  CHECK(ideal.residue_names.names == std::vector<std::string>{"ABC"});
  CHECK(ideal.atom_names.names == std::vector<std::string>{"C1", "O'"});
  CHECK(ideal.numbers[0].values == std::vector<double>{0, -1});
  const Particles model = read_cif(
      files, head + "ABC C1 C 0 1 1 1 5 5 5\nABC O1 O 0 2 2 2 ? ? ?\nABC H1 H 0 ? ? ? ? ? ?\n");
  CHECK(xs_of(model) == Xs{1, 2});
  CHECK(test::note(model, "unplaced") == 1);
  CHECK(files.message("a.cif", head + "ABC C1 C 0 ? 1 1 ? 5 5\n") == "a.cif:13: " + no_coordinates);
  CHECK(files.message("a.cif",
                      "data_a\nloop_\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n"
                      ". . .\n") == "a.cif:6: " + no_coordinates);
}

TEST_CASE("mmCIF: atoms without coordinates are counted in the chosen model alone") {
  const ParticleFiles files;
  const std::string path = files.write(
      "a.cif", cif("type_symbol Cartn_x Cartn_y Cartn_z pdbx_PDB_model_num",
                   "C ? ? ? 1\nC 1 1 1 1\nC 2 2 2 2\nC ? ? ? 3\nC ? ? ? 3\nC 3 3 3 3\n"));
  const auto unplaced = [&](FrameChoice frame) {
    ParticleRequest request;
    request.frame = frame;
    return test::note(read_particles(path, request), "unplaced");
  };
  CHECK(unplaced({0, false}) == 1);
  CHECK(unplaced({1, false}) == 0);
  CHECK(unplaced({0, true}) == 2);
}

TEST_CASE("mmCIF: models are frames; names, residues, numbers and the cell are read") {
  const ParticleFiles files;
  const std::string text =
      "data_a\n_cell.length_a 10\n_cell.length_b 20\n_cell.length_c 30\n_cell.angle_alpha 90\n"
      "_cell.angle_beta 90\n_cell.angle_gamma 90\nloop_\n_atom_site.type_symbol\n"
      "_atom_site.label_atom_id\n_atom_site.label_comp_id\n_atom_site.auth_asym_id\n"
      "_atom_site.auth_seq_id\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n"
      "_atom_site.B_iso_or_equiv\n_atom_site.pdbx_PDB_model_num\n"
      "C CA ALA B 12 1 2 3 7.5 1\nO . HOH C . 2 2 3 8.5 1\nC CA ALA B 12 3 2 3 9.5 2\n";
  const Particles first = read_cif(files, text);
  CHECK(xs_of(first) == Xs{1, 2});
  CHECK(first.facts.frames == 2);
  CHECK(first.residue_names.names == std::vector<std::string>{"ALA", "HOH"});
  CHECK(first.chains.names == std::vector<std::string>{"B", "C"});
  CHECK(first.residue_numbers == std::vector<std::int32_t>{12, 0});
  REQUIRE(first.numbers.size() == 1);
  CHECK(first.numbers[0].name == "b_factor");
  CHECK(first.numbers[0].values == std::vector<double>{7.5, 8.5});
  REQUIRE(first.cell.has_value());
  CHECK(first.cell->edges[1] == Vec3d{0, 20, 0});
  const auto xs = [&](FrameChoice frame) {
    ParticleRequest request;
    request.frame = frame;
    return xs_of(read_particles(files.write("a.cif", text), request));
  };
  CHECK(xs({1, false}) == Xs{3});
  CHECK(xs({0, true}) == Xs{3});
  CHECK(test::message_of<InputError>([&] {
          xs({2, false});
        }).ends_with("the file ends after 2 frames: it has no frame 2 (the first frame is 0)"));
}

TEST_CASE("CIF: the first block with atoms is read and a note counts the others") {
  const ParticleFiles files;
  const std::string atoms =
      "loop_\n_atom_site.type_symbol\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n";
  const std::string text =
      "data_global\n_journal.name x\ndata_a\n" + atoms + "C 1 2 3\ndata_b\n" + atoms + "C 4 2 3\n";
  CHECK(xs_of(read_cif(files, text)) == Xs{1});
  CHECK(test::note(read_cif(files, text), "blocks") == 1);
  std::string old = text;
  std::ranges::replace(old, '\n', '\r');
  CHECK(xs_of(read_cif(files, old)) == Xs{1});
}

TEST_CASE("mmCIF: without symbols the elements are guessed from names") {
  const ParticleFiles files;
  const Particles particles = read_cif(
      files,
      "data_a\nloop_\n_atom_site.label_atom_id\n_atom_site.label_comp_id\n_atom_site.Cartn_x\n"
      "_atom_site.Cartn_y\n_atom_site.Cartn_z\nCA ALA 1 2 3\nCA CA 4 5 6\n");
  CHECK(particles.elements == Elements{6, 20});
  CHECK(test::note(particles, "guessed_elements") == 2);
}

TEST_CASE("mmCIF: residues that differ only by the insertion code are different residues") {
  const ParticleFiles files;
  const Particles particles = files.read(
      "a.cif",
      "data_a\nloop_\n_atom_site.type_symbol\n_atom_site.auth_comp_id\n_atom_site.auth_seq_id\n"
      "_atom_site.pdbx_PDB_ins_code\n_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\n"
      "C PRO 60 ? 1 0 0\nC PRO 60 B 2 0 0\nC PRO 60 C 3 0 0\n");
  CHECK(particles.insertion_codes == std::vector<char>{' ', 'B', 'C'});
  CHECK(input::summary_of(particles).residues == 3);
}

}  // namespace parray
