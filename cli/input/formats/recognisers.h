#pragma once

#include "cli/input/particles/file_start.h"

/// What tells each format from the others, by its published description. Of a file that several
/// claim, at most one is `likely` or better, as far as their texts can be told apart.
namespace parray::input {

// Text; recognise_text.cpp.
Likeness looks_like_ply(const FileStart& start);
Likeness looks_like_csv(const FileStart& start);
Likeness looks_like_xyz(const FileStart& start);
Likeness looks_like_lammps_dump(const FileStart& start);
/// LAMMPS manual, read_data.
Likeness looks_like_lammps_data(const FileStart& start);
/// GROMACS reference manual, file formats.
Likeness looks_like_gro(const FileStart& start);
/// AMBER's formatted restart files: a title, a count, six coordinates of 12.7 a line.
Likeness looks_like_inpcrd(const FileStart& start);

// Of molecules; recognise_molecules.cpp.
/// wwPDB, "Protein Data Bank Contents Guide", version 3.30.
Likeness looks_like_pdb(const FileStart& start);
/// AutoDock Vina's manual: PDB with charges in columns 71 to 76 and roots and branches.
Likeness looks_like_pdbqt(const FileStart& start);
/// APBS's manual: as PDB, separated by blanks, with a charge and a radius at the end of the line.
Likeness looks_like_pqr(const FileStart& start);
/// mmCIF (PDBx), whose names have a dot.
Likeness looks_like_mmcif(const FileStart& start);
/// CIF of crystals (the core dictionary), whose names have none.
Likeness looks_like_cif(const FileStart& start);
/// CTfile formats, V2000 and V3000.
Likeness looks_like_sdf(const FileStart& start);
/// Tripos Mol2 File Format.
Likeness looks_like_mol2(const FileStart& start);
/// Of X-PLOR, CHARMM and NAMD: names and bonds, no positions.
Likeness looks_like_psf(const FileStart& start);
/// AMBER's topology.
Likeness looks_like_prmtop(const FileStart& start);

// Binary; recognise_binary.cpp.
/// CHARMM's and NAMD's trajectory, of either byte order.
Likeness looks_like_dcd(const FileStart& start);
/// GROMACS's trajectories.
Likeness looks_like_xtc(const FileStart& start);
Likeness looks_like_trr(const FileStart& start);
/// NetCDF's classic formats: AMBER's trajectories and restart files.
Likeness looks_like_netcdf(const FileStart& start);
Likeness looks_like_hdf5(const FileStart& start);
/// HOOMD-blue's general simulation data.
Likeness looks_like_gsd(const FileStart& start);

}  // namespace parray::input
