#include "cli/input/formats/notes.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/molecule_files.h"
#include "tests/support/particle_columns.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::ParticleFiles;
using test::told;

}  // namespace

TEST_CASE("LAMMPS: a note counts ellipsoids and other bodies, which are shown as spheres") {
  const ParticleFiles files;
  const auto dump = [](const std::string& columns, const std::string& rows) {
    return "ITEM: NUMBER OF ATOMS\n2\nITEM: ATOMS id x y z" + columns + "\n" + rows;
  };
  const std::string shapes =
      dump(" shapex shapey shapez quatw", "1 0 0 0 1 1 3 0.7\n2 5 0 0 1 1 1 0.7\n");
  CHECK(told(files.read("a.dump", shapes), "ellipsoids") == "1 ellipsoid shown as a sphere");
  const std::string turned = dump(" quatw quati", "1 0 0 0 1 0\n2 5 0 0 1 0\n");
  CHECK(told(files.read("a.dump", turned), "ellipsoids") == "2 ellipsoids shown as spheres");
  CHECK(told(files.read("a.dump", dump("", "1 0 0 0\n2 5 0 0\n")), "ellipsoids").empty());
  const std::string head = "title\n\n2 atoms\n1 atom types\n";
  const std::string box = "0 9 xlo xhi\n0 9 ylo yhi\n0 9 zlo zhi\n\n";
  const std::string ellipsoids =
      head + "2 ellipsoids\n" + box +
      "Atoms # ellipsoid\n\n1 1 1 1 0 0 0\n2 1 1 1 5 0 0\n\nEllipsoids\n\n1 1 2 2 1 0 0 0\n"
      "2 2 2 2 1 0 0 0\n";
  CHECK(told(files.read("a.data", ellipsoids), "ellipsoids") == "1 ellipsoid shown as a sphere");
  const std::string lines = head + "2 lines\n" + box +
                            "Atoms # line\n\n1 1 1 1 1 0 0 0\n2 1 1 1 1 5 0 0\n\nLines\n\n"
                            "1 0 0 1 1\n2 4 0 6 1\n";
  CHECK(told(files.read("a.data", lines), "bodies") ==
        "2 line segments, triangles or bodies shown as spheres");
}

TEST_CASE("CIF: a note counts bonds of _geom_bond, which are not read") {
  const ParticleFiles files;
  const std::string head = "data_a\n_cell_length_a 4\n_cell_length_b 5\n_cell_length_c 6\n";
  const std::string sites =
      "loop_\n_atom_site_label\n_atom_site_fract_x\n_atom_site_fract_y\n_atom_site_fract_z\n"
      "C1 0 0 0\nO1 0.3 0 0\n";
  const std::string bonds =
      "loop_\n_geom_bond_atom_site_label_1\n_geom_bond_atom_site_label_2\n_geom_bond_distance\n";
  const std::string rows = "C1 O1 1.2\nC1 C1 4.0\n";
  CHECK(told(files.read("a.cif", head + sites), "geometry_bonds").empty());
  CHECK(told(files.read("a.cif", head + sites + bonds + rows), "geometry_bonds") ==
        "2 bonds of the table _geom_bond not read: ParRay finds bonds by distances");
  CHECK(told(files.read("a.cif", head + bonds + "C1 O1 1.2\n" + sites), "geometry_bonds") ==
        "1 bond of the table _geom_bond not read: ParRay finds bonds by distances");
  const std::string other = "data_b\n" + bonds + rows;
  CHECK(told(files.read("a.cif", other + head + sites + other), "geometry_bonds").empty());
}

TEST_CASE("a note counts particles without a known element if masses give only some elements") {
  const ParticleFiles files;
  const std::string data =
      "title\n\n2 atoms\n2 atom types\n0 9 xlo xhi\n0 9 ylo yhi\n0 9 zlo zhi\n\nMasses\n\n"
      "1 12.011\n2 777\n\nAtoms # atomic\n\n1 1 0 0 0\n2 2 1 0 0\n";
  CHECK(told(files.read("a.data", data), "unknown_elements") == "1 particle of an unknown element");
  const std::string psf =
      "PSF\n\n 1 !NTITLE\n x\n\n 2 !NATOM\n 1 A 1 ALA CA CT1 0.1 12.011 0\n"
      " 2 A 2 RES QQ QQ 0.1 72.5 0\n";
  CHECK(test::note(read_names(files.write("a.psf", psf)), "unknown_elements") == 1);
}

}  // namespace parray
