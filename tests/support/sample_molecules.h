#pragma once

#include <map>
#include <string>

#include "tests/support/rooms.h"

namespace parray::test {

/// Returns, by name, a small file of every format of molecules. Each uses most features of its
/// format.
inline std::map<std::string, std::string> valid_molecule_files() {
  return {
      {"b.pdb",
       "CRYST1   10.000   20.000   30.000  90.00  91.00  92.00 P 1           1\n"
       "ATOM  100000  C1 ALIG AA000      1.000   2.000   3.000  1.00  0.00      SEGA\n"
       "ATOM\t2\tCA\tALA\tA\t12\t1.5\t2.5\t3.5\t1.00\t0.00\tC\n"
       "HETATM    3 CA    CA A****    -1000.000 2.000   3.000  1.00  0.00\nEND\n"
       "atom      1  o   hoh a   1A      1.000   2.000   3.000  1.00  0.00          CAO1-\nend\n"},
      {"a.pdbqt",
       "MODEL 1\nROOT\n"
       "ATOM      1  CA  LIG A   1       1.000   2.000   3.000  1.00  0.00    +0.123 A \n"
       "ATOM      2  N1  LIG A   1       2.000   2.000   3.000  1.00  0.00    -0.250 NA\n"
       "ENDROOT\nBRANCH   2   3\n"
       "ATOM      3  G   LIG A   1       3.000   2.000   3.000  1.00  0.00     0.163 G0\nENDMDL\n"},
      {"a.pqr",
       "REMARK\nATOM      1  N   ALA A   1      1.0 2.0 3.0 -0.4 1.55\nATOM 2 CA ALA 2 4.0 5.5 6.0 "
       "0.1 0\n"
       "ATOM  12345 HD11 LEU A1000    -110.123-100.456 -99.000  0.1000 1.2000\nEND\n"},
      {"a.gro",
       "Water, t= 12.5\n  2\n    1SOL     OW    1   0.126   1.624   1.679  0.1227 -0.0580  0.0434\n"
       "    1SOL     MW    2   0.190   1.661   1.747\n   1.82060   1.82060   1.82060\n"
       "\n1\n99999ION    CL    1   1.12345   2.12345  -3.12345\n 1 2 3 0 0 0.5 0 0.25 0.125\n"},
      {"a.sdf",
       "name\n\n\n  2  1  0  0  0  0            999 V2000\n"
       "    1.0000    0.0000    0.0000 C   0  3  0  0  0  0\n"
       "   -0.5000    0.2500    0.1250 R#  0  5  0  0  0  0\n  1  2  1  0\nM  CHG  1   1   2\nM  "
       "END\n"
       "> <id>\n1\n\n$$$$\n\n\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\n"
       "M  V30 COUNTS 2 0 0 0 0\nM  V30 BEGIN ATOM\nM  V30 1 N 1.5 2.5 3.5 0 CHG=1\n"
       "M  V30 2 Cl 4.5 5.5 -\nM  V30 6.5 0\nM  V30 END ATOM\nM  V30 END CTAB\nM  END\n$$$$\n"},
      {"a.mol2",
       "# c\n@<TRIPOS>MOLECULE\nfirst\n 2 0 1\nSMALL\nUSER_CHARGES\n\n@<TRIPOS>ATOM\n"
       "1 CA 1.0 0.0 0.0 C.ar 1 ALA12 -0.5\n2 X1 2.0 0.0 0.0 ca 2 LIG 0.25\n@<TRIPOS>CRYSIN\n"
       "10 20 30 90 90 90 1 1\n@<TRIPOS>MOLECULE\nsecond\n@<TRIPOS>ATOM\n1 BR 7 0 0 Br\n"},
      {"a.vasp",
       "salt\n1.5\n2 0 0\n0 4 0\n1 0 8\nNa_pv Cl Qq\n1 1 1\nSelective dynamics\nDirect\n"
       "0 0 0 T T F\n0.5 0.25 0.5 F F F\n0.1 0.2 0.3 T T T\n\n0.5 0 0\n0 0.5 0\n0 0 -0.5\n"},
      {"b.vasp", "NaCl\n-100\n2 0 0\n0 4 0\n1 0 8\n1 1 ! counts\nCartesian\n0 0 0 Na\n1 2 3 Cl\n"},
      {"c.vasp",
       "gas\n1 2 3\n2 0 0\n0 4 0\n1 0 8\nAr\n1\nDirect configuration=     1\n0 0 0\n"
       "gas\n2\n2 0 0\n0 4 0\n1 0 8\nAr\n1\nDirect configuration=     2\n0.5 0.5 0.5\n"},
      {"b.cif",
       "data_a\n_cell_length_a 4.0(1)\n_cell_length_b 5\n_cell_length_c 6\n_cell_angle_alpha 90\n"
       "_cell_angle_beta 91\n_cell_angle_gamma 90\nloop_\n_symmetry_equiv_pos_as_xyz\n'x,y,z'\n"
       "'-x, -y, 1/2+z'\nloop_\n_atom_site_label\n_atom_site_type_symbol\n_atom_site_fract_x\n"
       "_atom_site_fract_y\n_atom_site_fract_z\n_atom_site_occupancy\n_atom_site_disorder_group\n"
       "Ca1 Ca2+ 0.25 0.5(1) 0.125 1 .\nO1 O2- 0 0 -0.25 0.4 1\nC1 ? 0 0 0 0.6 2\nMg1 Mg ? ? ? 1 "
       ".\n"},
      {"c.cif",
       "data_a\n_symmetry_space_group_name_H-M 'F m -3 m'\n_cell_length_a 4\n_cell_length_b 4\n"
       "_cell_length_c 4\n_atom_site_label NA1\n_atom_site_fract_x 0\n_atom_site_fract_y 0\n"
       "_atom_site_fract_z 0\n"},
      {"d.cif",
       "data_ABC\nloop_\n_chem_comp_atom.comp_id\n_chem_comp_atom.atom_id\n"
       "_chem_comp_atom.type_symbol\n_chem_comp_atom.model_Cartn_x\n_chem_comp_atom.model_Cartn_y\n"
       "_chem_comp_atom.model_Cartn_z\n_chem_comp_atom.pdbx_model_Cartn_x_ideal\n"
       "_chem_comp_atom.pdbx_model_Cartn_y_ideal\n_chem_comp_atom.pdbx_model_Cartn_z_ideal\n"
       "ABC C1 C 1 1 1 5 5 5\nABC \"O'\" O ? ? ? 6 6 6\nABC H1 H 1 1 1 ? ? ?\n"}};
}

}  // namespace parray::test
