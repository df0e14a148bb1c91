#include <doctest/doctest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "cli/input/particles/frames.h"
#include "cli/input/particles/particle_input.h"
#include "tests/support/molecule_files.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_gsd.h"
#include "tests/support/sample_trajectories.h"

namespace parray {
namespace {

using test::note;
using test::ParticleFiles;
using Bonds = std::vector<StatedBond>;

/// Returns a record of PDB with this serial number, five characters wide, in residue `number`.
std::string atom_record(const std::string& serial, const std::string& name, int number, double x,
                        char location = ' ') {
  std::string line = test::pdb_line(name, location, "LIG", number, x, 1, " C");
  return line.replace(6, 5, serial);
}

std::string three_atoms_of_pdb() {
  return atom_record("    1", " C1", 1, 1) + atom_record("    2", " C2", 1, 2) +
         atom_record("    3", " C3", 1, 3);
}

const std::string data_head =
    "title\n\n3 atoms\n2 bonds\n1 bond types\n1 atom types\n0 9 xlo xhi\n0 9 ylo yhi\n"
    "0 9 zlo zhi\n\nAtoms # bond\n\n30 1 1 0 0 0\n10 1 1 1 0 0\n20 1 1 2 0 0\n\nBonds\n\n";

const std::string sdf_head =
    "a\n\n\n  2  1  0  0  0  0  0  0  0  0  1 V2000\n    1.0000    2.0000    3.0000 C   0  0\n"
    "    2.0000    2.0000    3.0000 O   0  0\n";

const std::string mol2_head =
    "@<TRIPOS>MOLECULE\na\n@<TRIPOS>ATOM\n1 C 1 2 3 C.3\n2 O 2 2 3 O.2\n@<TRIPOS>BOND\n";

/// Returns V3000 with two atoms, numbered 7 and 3, and this bond.
std::string v3000(const std::string& bond) {
  return "a\n\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\n"
         "M  V30 COUNTS 2 1 0 0 0\nM  V30 BEGIN ATOM\nM  V30 7 C 1 2 3 0\nM  V30 3 O 2 2 3 0\n"
         "M  V30 END ATOM\nM  V30 BEGIN BOND\nM  V30 1 2 " +
         bond + "\nM  V30 END BOND\nM  V30 END CTAB\nM  END\n";
}

std::string psf_with(const std::string& bonds) {
  return "PSF\n\n 3 !NATOM\n 1 A 1 ALA CA CT1 0.1 12.011 0\n 2 A 1 ALA CB CT1 0.1 12.011 0\n"
         " 3 A 1 ALA C CT1 0.1 12.011 0\n\n 2 !NBOND: bonds\n" +
         bonds;
}

std::string prmtop_with(const std::string& bonds) {
  std::string text = test::prmtop();
  const std::string pointers = "       3       2       0";
  text.replace(text.find(pointers), pointers.size(), "       3       2       2");
  return text + "%FLAG BONDS_INC_HYDROGEN\n%FORMAT(10I8)\n" + bonds;
}

Particles read_as_names(const ParticleFiles& files, const std::string& name,
                        const std::string& text) {
  return read_names(files.write(name, text));
}

/// Returns the error message of reading the names, without the directory.
std::string message_of_names(const ParticleFiles& files, const std::string& name,
                             const std::string& text) {
  const std::string message =
      test::message_of<InputError>([&] { (void)read_as_names(files, name, text); });
  return message.substr(message.rfind('/') + 1);
}

}  // namespace

TEST_CASE("PDB: CONECT gives each bond once, though files repeat bonds in both directions") {
  const ParticleFiles files;
  const std::string bonds = "CONECT    1    2    3\nCONECT    2    1    1\nCONECT    3    1\n";
  const Particles ligand = files.read("a.pdb", three_atoms_of_pdb() + bonds + "END\n");
  CHECK(ligand.bonds == Bonds{{0, 1}, {0, 2}});
  CHECK_FALSE(ligand.all_bonds);
  CHECK(files.read("a.pdb", three_atoms_of_pdb() + "END\n").bonds.empty());
  const std::string two = "MODEL 1\n" + three_atoms_of_pdb() + "ENDMDL\n";
  CHECK(files.read("a.pdb", two + bonds).bonds == Bonds{{0, 1}, {0, 2}});
  const std::string later = three_atoms_of_pdb() + "END\n" + three_atoms_of_pdb() + bonds;
  CHECK(files.read("a.pdb", later).bonds.empty());  // they belong to the second frame
}

TEST_CASE("PDB: CONECT after the last model gives each model its bonds") {
  const ParticleFiles files;
  const std::string model = "MODEL        1\n" + three_atoms_of_pdb() + "ENDMDL\n";
  const std::string shared = "CONECT    1    2\nMASTER        0\nEND\n";
  const auto bonds_in = [&](const std::string& text, std::uint64_t frame) {
    ParticleRequest request;
    request.frame = FrameChoice{frame, false};
    return read_particles(files.write("a.pdb", text), request).bonds;
  };
  const std::string remark(5000, ' ');
  const std::string long_models = model + "REMARK" + remark + "\n" + model + model;
  for (const std::string& text : {model + model + model + shared, long_models + shared}) {
    for (std::uint64_t frame = 0; frame < 3; ++frame) CHECK(bonds_in(text, frame) == Bonds{{0, 1}});
  }
  CHECK(bonds_in(long_models + "END\n", 0).empty());
  // Records inside or right after a model belong to this model alone.
  const std::string own = "CONECT    2    3\n";
  const std::string inside = "MODEL 2\n" + three_atoms_of_pdb() + own + "ENDMDL\n";
  CHECK(bonds_in(model + own + model + shared, 0) == Bonds{{1, 2}});
  CHECK(bonds_in(model + inside, 0).empty());
  CHECK(bonds_in(model + inside + shared, 0) == Bonds{{0, 1}});
}

TEST_CASE(
    "PDB: the first models of a damaged file are read, without the bonds after the last model") {
  const ParticleFiles files;
  const std::string model = "MODEL        1\n" + three_atoms_of_pdb() + "ENDMDL\n";
  const std::string damage(2 * ParticleInput::max_line_bytes, 'x');
  const std::string text = model + model + damage + "\nCONECT    1    2\nEND\n";
  CHECK(files.read("a.pdb", text).count() == 3);
  CHECK(files.read("a.pdb", text).bonds.empty());
}

TEST_CASE("PDB: the frames of a film are read in one pass, with the bonds of all models") {
  const ParticleFiles files;
  const std::string model = "MODEL        1\n" + three_atoms_of_pdb() + "ENDMDL\n";
  PackedFile file(files.write("a.pdb", model + model + model + "CONECT    1    2\nEND\n"));
  FrameCursor cursor;
  ParticleRequest request;
  request.cursor = &cursor;
  for (std::uint64_t frame = 0; frame < 3; ++frame) {
    request.frame = FrameChoice{frame, false};
    const std::uint64_t before = file.rewinds();
    CHECK(read_particles(file, request).bonds == Bonds{{0, 1}});
    CHECK((file.rewinds() == before) == (frame > 0));
  }
}

TEST_CASE("PDB: serial numbers of CONECT may be hybrid-36, hexadecimal, long or out of order") {
  const ParticleFiles files;
  const std::string hybrid = atom_record("99999", " C1", 1, 1) + atom_record("A0000", " C2", 1, 2);
  CHECK(files.read("a.pdb", hybrid + "CONECT99999A0000\n").bonds == Bonds{{0, 1}});
  const std::string hexadecimal =
      atom_record("99999", " C1", 1, 1) + atom_record("186a0", " C2", 1, 2);
  CHECK(files.read("a.pdb", hexadecimal + "CONECT99999186a0\n").bonds == Bonds{{0, 1}});
  std::string longer = atom_record("    5", " C1", 1, 1) + atom_record("    7", " C2", 1, 2);
  longer.replace(longer.find("    5"), 5, "100005");
  CHECK(files.read("a.pdb", longer + "CONECT 100005 7\n").bonds == Bonds{{0, 1}});
  const std::string dense = atom_record(" 2462", " C1", 1, 1) + atom_record("12276", " C2", 1, 2) +
                            atom_record("12280", " C3", 1, 3) +
                            "CONECT 24621227612280\nCONECT12276 246212280\n";
  CHECK(files.read("a.pdb", dense).bonds == Bonds{{0, 1}, {0, 2}, {1, 2}});
  const std::string descending = atom_record("    9", " C1", 1, 1) +
                                 atom_record("    4", " C2", 1, 2) + "TER       5\n" +
                                 atom_record("    6", " C3", 1, 3);
  CHECK(files.read("a.pdb", descending + "CONECT    6    9\nCONECT    4    9\n").bonds ==
        Bonds{{0, 1}, {0, 2}});
}

TEST_CASE(
    "PDB: bonds to missing or ambiguous atoms, and to the atom itself, are counted in a note") {
  const ParticleFiles files;
  const Particles ligand = files.read(
      "a.pdb", three_atoms_of_pdb() + "CONECT    1    2    9    1\nCONECT    8    7\nEND\n");
  CHECK(ligand.bonds == Bonds{{0, 1}});
  CHECK(note(ligand, "unknown_bonds") == 3);
  const std::string twice = three_atoms_of_pdb() + atom_record("    1", " C4", 1, 4);
  const Particles ambiguous = files.read("a.pdb", twice + "CONECT    1    2\nCONECT    2    3\n");
  CHECK(ambiguous.bonds == Bonds{{1, 2}});
  CHECK(note(ambiguous, "unknown_bonds") == 1);
}

TEST_CASE("PDB: bonds follow the atoms when alternative locations are left out") {
  const ParticleFiles files;
  const std::string text =
      atom_record("    1", " C1", 1, 1) + atom_record("    2", " C2", 1, 2, 'A') +
      atom_record("    3", " C2", 1, 2.5, 'B') + atom_record("    4", " C3", 1, 3) +
      "CONECT    1    2    3\nCONECT" + "    4    2    3\nEND\n";
  const Particles best = files.read("a.pdb", text);
  CHECK(best.bonds == Bonds{{0, 1}, {1, 2}});
  CHECK(best.alternatives.empty());
  ParticleRequest request;
  request.alternatives.rule = AlternativeChoice::Rule::all;
  const Particles all = read_particles(files.write("a.pdb", text), request);
  CHECK(all.bonds == Bonds{{0, 1}, {0, 2}, {1, 3}, {2, 3}});
  CHECK(all.alternatives == std::vector<char>{' ', 'A', 'B', ' '});
}

TEST_CASE("PDBQT: CONECT is read as in PDB") {
  const ParticleFiles files;
  const std::string text =
      "ROOT\nATOM      1  CA  LIG A   1       1.000   2.000   3.000  1.00  0.00    +0.123 A \n"
      "ATOM      2  N1  LIG A   1       2.000   2.000   3.000  1.00  0.00    -0.250 NA\n"
      "ENDROOT\nCONECT    1    2\n";
  CHECK(files.read("a.pdbqt", text).bonds == Bonds{{0, 1}});
}

TEST_CASE("MOL2: bonds name atoms in the order of the file; 'nc' is no bond") {
  const ParticleFiles files;
  const Particles molecule = files.read(
      "a.mol2", mol2_head + "1 2 1 2\n@<TRIPOS>MOLECULE\nb\n@<TRIPOS>ATOM\n1 C 1 2 3 C.3\n");
  CHECK(molecule.bonds == Bonds{{0, 1}});
  CHECK(molecule.all_bonds);
  CHECK(files.read("a.mol2", mol2_head + "1 2 1 nc\n").bonds.empty());
  CHECK(files.message("a.mol2", mol2_head + "1 2 3 2\n") ==
        "a.mol2:7: a bond has the atom '3': use a number from 1 to 2");
  CHECK(files.message("a.mol2", mol2_head + "1 2 2 2\n") ==
        "a.mol2:7: atom 2 bonds to itself: remove the bond");
  CHECK(files.message("a.mol2", mol2_head + "1 2\n") ==
        "a.mol2:7: the line needs number, two atoms and type of a bond: check that the file is "
        "complete");
  CHECK(files.message("a.mol2", "@<TRIPOS>MOLECULE\na\n@<TRIPOS>BOND\n1 1 2 1\n@<TRIPOS>ATOM\n") ==
        "a.mol2:4: section BOND precedes the atoms: move section ATOM before it");
}

TEST_CASE("SDF: V2000 has the bonds of its bond block") {
  const ParticleFiles files;
  const Particles molecule = files.read("a.sdf", sdf_head + "  2  1  2  0\nM  END\n$$$$\n");
  CHECK(molecule.bonds == Bonds{{0, 1}});
  CHECK(molecule.all_bonds);
  CHECK(files.message("a.sdf", sdf_head + "  1  3  2  0\nM  END\n") ==
        "a.sdf:7: a bond has the atom '3': use a number from 1 to 2");
  CHECK(files.message("a.sdf", sdf_head + "  1  1  2  0\nM  END\n") ==
        "a.sdf:7: atom 1 bonds to itself: remove the bond");
  CHECK(files.message("a.sdf", sdf_head + "$$$$\n") ==
        "a.sdf:7: the molecule ends before its 2 atoms and 1 bonds: check these numbers");
}

TEST_CASE("SDF: bonds of V3000 use the numbers of the atoms") {
  const ParticleFiles files;
  CHECK(files.read("a.sdf", v3000("3 7")).bonds == Bonds{{0, 1}});
  CHECK(files.read("a.sdf", v3000("3 -\nM  V30 7")).bonds == Bonds{{0, 1}});
  CHECK(files.message("a.sdf", v3000("3 1")) ==
        "a.sdf:12: a bond has the atom '1', but no atom, or more than one, has this number: check "
        "the numbers of the atoms");
  CHECK(files.message("a.sdf", v3000("3 3")) ==
        "a.sdf:12: atom 3 bonds to itself: remove the bond");
}

TEST_CASE("LAMMPS data: bonds use the numbers of the atoms, which may be in any order") {
  const ParticleFiles files;
  const Particles polymer = files.read("a.data", data_head + "1 1 10 20\n2 1 30 10\n");
  CHECK(polymer.bonds == Bonds{{0, 1}, {1, 2}});
  CHECK(polymer.all_bonds);
  CHECK(
      files.message("a.data", data_head + "1 1 10 40\n2 1 30 10\n") ==
      "a.data:19: a bond has the atom '40', but no atom, or more than one, has this number: check "
      "the numbers of the atoms");
  CHECK(files.message("a.data", data_head + "1 1 10 20\n") ==
        "a.data:19: the file has only 1 of 2 bonds: check that the file is complete");
}

TEST_CASE("PSF: the section NBOND has pairs of atoms") {
  const ParticleFiles files;
  const Particles names = read_as_names(files, "a.psf", psf_with(" 2 1 2 3\n"));
  CHECK(names.bonds == Bonds{{0, 1}, {1, 2}});
  CHECK(names.all_bonds);
  CHECK(read_as_names(files, "a.psf", psf_with(" 2 1\n 2 3\n")).bonds.size() == 2);
  CHECK(message_of_names(files, "a.psf", psf_with(" 2 1 2 4\n")) ==
        "a.psf:9: a bond has the atom '4': use a number from 1 to 3");
  CHECK(message_of_names(files, "a.psf", psf_with(" 2 1 2\n")) ==
        "a.psf:9: a bond has the atom '': use a number from 1 to 3");
  CHECK(message_of_names(files, "a.psf", psf_with("")) ==
        "a.psf:8: the file ends after 0 of 2 bonds: check that the file is complete");
}

TEST_CASE("PRMTOP: bonds are three times the places of atoms") {
  const ParticleFiles files;
  const Particles water = read_as_names(
      files, "a.prmtop", prmtop_with("       0       3       1       0       6       1\n"));
  CHECK(water.bonds == Bonds{{0, 1}, {0, 2}});
  CHECK(water.all_bonds);
  CHECK(read_as_names(files, "a.prmtop", test::prmtop()).bonds.empty());
  const std::string odd = message_of_names(
      files, "a.prmtop", prmtop_with("       0       4       1       0       6       1\n"));
  CHECK(odd.ends_with(
      "a.prmtop:27: a bond has the offset '4', which is not a multiple of 3: check that the file "
      "is complete"));
  const std::string outside = message_of_names(
      files, "a.prmtop", prmtop_with("       0       9       1       0       6       1\n"));
  CHECK(outside.ends_with("a bond has the atom '4': use a number from 1 to 3"));
}

TEST_CASE("PRMTOP: an error names its section; residues begin at ascending atoms of the file") {
  const ParticleFiles files;
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string text = test::prmtop();
    return message_of_names(files, "a.prmtop", text.replace(text.find(from), from.size(), to));
  };
  const std::string pointer = "POINTER\n%FORMAT(10I8)\n       ";
  for (const std::string bad : {"0", "4", "x"}) {
    CHECK(message(pointer + "1", pointer + bad) ==
          "a.prmtop:21: RESIDUE_POINTER has '" + bad +
              "': write the number of the first atom of each residue, ascending from 1 to 3");
  }
  CHECK(message("WAT \n", "WAT ION \n") ==
        "a.prmtop:18: section RESIDUE_LABEL has 2 fields instead of 1: check that the file is "
        "complete");
  CHECK(message("       0       1\n", "       0       x\n").starts_with("a.prmtop:5: 'x'"));
  CHECK(message("%FLAG MASS\n%FORMAT(5E16.8)\n", "%FLAG MASS\n")
            .ends_with("fields precede their %FORMAT: check that the file is complete"));
}

TEST_CASE("Tinker: an atom names the atoms to which it bonds") {
  const ParticleFiles files;
  const std::string text = "2 x\n1 C 1 0 0 1 2\n2 O 2 0 0 1 ";
  CHECK(files.read("a.txyz", text + "1\n").bonds == Bonds{{0, 1}});
  CHECK(files.message("a.txyz", text + "3\n") ==
        "a.txyz:3: a bond has the atom '3': use a number from 1 to 2");
}

TEST_CASE("GSD: frames inherit the bonds of frame 0 unless they have their own") {
  const ParticleFiles files;
  const auto bonds = [](const std::vector<std::uint32_t>& pairs) {
    return test::gsd_part<std::uint32_t>("bonds/group", 3, 2, pairs);
  };
  const auto count = [](std::uint32_t number) {
    return test::gsd_part<std::uint32_t>("bonds/N", 3, 1, {number});
  };
  const test::GsdFrameParts three{
      test::gsd_count(3), test::gsd_floats("particles/position", 3, {0, 0, 0, 1, 0, 0, 2, 0, 0})};
  test::GsdFrameParts first = three;
  first.insert(first.end(), {count(2), bonds({2, 1, 0, 1})});
  test::GsdFrameParts last = three;
  last.push_back(count(0));
  const auto path = files.write("a.gsd", test::gsd_file({first, three, last}));
  const auto read = [&](std::uint64_t frame) {
    return read_particles(path, {.frame = FrameChoice{frame, false}});
  };
  CHECK(read(0).bonds == Bonds{{0, 1}, {1, 2}});
  CHECK(read(0).all_bonds);
  CHECK(read(1).bonds == Bonds{{0, 1}, {1, 2}});
  CHECK(read(2).bonds.empty());
  first.back() = bonds({2, 3, 0, 1});
  CHECK(files.message("a.gsd", test::gsd_file({first})).find("a bond has the particle 3 of 3") !=
        std::string::npos);
}

TEST_CASE("mmCIF: struct_conn gives covalent, disulfide and metal bonds of one asymmetric unit") {
  const ParticleFiles files;
  const std::string atoms =
      "data_a\nloop_\n_atom_site.type_symbol\n_atom_site.label_atom_id\n_atom_site.label_comp_id\n"
      "_atom_site.auth_asym_id\n_atom_site.auth_seq_id\n_atom_site.pdbx_PDB_ins_code\n"
      "_atom_site.Cartn_x\n_atom_site.Cartn_y\n_atom_site.Cartn_z\nS SG CYS A 5 ? 0 0 0\n"
      "S SG CYS A 9 ? 2 0 0\nN \"N'\" LIG B 9 B 4 0 0\nMG MG MG C 9 ? 6 0 0\n";
  const std::string columns =
      "_struct_conn.id\n_struct_conn.conn_type_id\n_struct_conn.ptnr1_auth_asym_id\n"
      "_struct_conn.ptnr1_auth_seq_id\n_struct_conn.ptnr1_label_atom_id\n"
      "_struct_conn.pdbx_ptnr1_PDB_ins_code\n_struct_conn.ptnr1_symmetry\n"
      "_struct_conn.ptnr2_auth_asym_id\n_struct_conn.ptnr2_auth_seq_id\n"
      "_struct_conn.ptnr2_label_atom_id\n_struct_conn.pdbx_ptnr2_PDB_ins_code\n"
      "_struct_conn.ptnr2_symmetry\n";
  const std::string rows =
      "a disulf A 5 SG ? 1_555 A 9 SG ? 1_555\nb covale A 9 SG ? 1_555 B 9 \"N'\" B 1_555\n"
      "c metalc C 9 MG ? 1_555 A 5 SG ? 1_555\nd hydrog A 5 SG ? 1_555 B 9 \"N'\" B 1_555\n"
      "e covale A 5 SG ? 1_555 B 9 \"N'\" B 2_555\nf covale A 5 SG ? 1_555 A 7 SG ? 1_555\n";
  for (const std::string& text :
       {atoms + "#\nloop_\n" + columns + rows,
        atoms.substr(0, 7) + "loop_\n" + columns + rows + atoms.substr(7)}) {
    const Particles protein = files.read("a.cif", text);
    CHECK(protein.bonds == Bonds{{0, 1}, {0, 3}, {1, 2}});
    CHECK_FALSE(protein.all_bonds);
    CHECK(note(protein, "unknown_bonds") == 1);
  }
  const std::string single =
      "_struct_conn.conn_type_id disulf\n_struct_conn.ptnr1_auth_asym_id A\n"
      "_struct_conn.ptnr1_auth_seq_id 5\n_struct_conn.ptnr1_label_atom_id SG\n"
      "_struct_conn.ptnr2_auth_asym_id A\n_struct_conn.ptnr2_auth_seq_id 9\n"
      "_struct_conn.ptnr2_label_atom_id SG\n";
  CHECK(files.read("a.cif", atoms + "#\n" + single).bonds == Bonds{{0, 1}});
}

TEST_CASE("CIF: a component has the bonds of chem_comp_bond") {
  const ParticleFiles files;
  const std::string text =
      "data_ABC\nloop_\n_chem_comp_atom.comp_id\n_chem_comp_atom.atom_id\n"
      "_chem_comp_atom.type_symbol\n_chem_comp_atom.model_Cartn_x\n_chem_comp_atom.model_Cartn_y\n"
      "_chem_comp_atom.model_Cartn_z\nABC C1 C 1 1 1\nABC \"O'\" O 2 1 1\nABC H1 H 0 1 1\n#\n"
      "loop_\n_chem_comp_bond.comp_id\n_chem_comp_bond.atom_id_1\n_chem_comp_bond.atom_id_2\n"
      "ABC \"O'\" C1\nABC C1 H1\n";
  const Particles component = files.read("a.cif", text);
  CHECK(component.bonds == Bonds{{0, 1}, {0, 2}});
  CHECK(component.all_bonds);
}

TEST_CASE("a trajectory takes the bonds of its topology, for the same atoms") {
  const ParticleFiles files;
  ParticleRequest request;
  request.topology = files.write("a.data", data_head + "1 1 10 20\n2 1 20 30\n");
  const auto trajectory = files.write("a.dcd", test::dcd_file({{{1, 0, 0}, {2, 0, 0}, {3, 0, 0}}}));
  const Particles ordered = read_particles(trajectory, request);  // atoms 10, 20, 30
  CHECK(ordered.bonds == Bonds{{0, 1}, {1, 2}});
  CHECK(ordered.all_bonds);
  const auto dump = files.write(
      "a.dump",
      "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n3\nITEM: BOX BOUNDS pp pp pp\n0 8\n0 8\n0 8\n"
      "ITEM: ATOMS id x y z\n20 1 0 0\n30 2 0 0\n10 3 0 0\n");
  CHECK(read_particles(dump, request).bonds == Bonds{{0, 1}, {0, 2}});
}

}  // namespace parray
