#pragma once

#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/particles.h"

/// One reader a format. All throw InputError as read_particles() does. Those of formats that hold
/// several frames read the one that the request chooses.
namespace parray::input {

/// What is told of files whose lengths are in nm.
inline constexpr const char* nm_text = "positions given in nm, turned into angstrom";

/// PLY 1.0, ascii and binary of both byte orders. Element "vertex" with x, y, z of any scalar type;
/// radius (or r, where there is no g and b); red, green, blue (or r, g, b): uchar is 8-bit sRGB,
/// float and double are linear from 0 to 1. Other properties and elements are passed over. `scale`
/// is passed over too: programs write lengths, factors and logarithms under that name.
Particles read_ply(PackedFile& file, const ParticleRequest& request);

/// A table with one header line; the columns are those of layout_of(), letter case aside. The first
/// comma, semicolon or tab of the header separates fields; where it has none, blanks do. Fields may
/// stand in double quotes ("" is a quote). Blank lines and lines that start with # are comments.
/// Colours are whole numbers 0 to 255 (8-bit sRGB) if any component is above 1, else linear.
Particles read_csv(PackedFile& file, const ParticleRequest& request);

/// XYZ: a count, a comment, then a name and three numbers a line; what follows them is ignored.
/// The name is a symbol, an atomic number or any other (element unknown). Names that are numbers
/// are types, told by a note, where the comment is LAMMPS's own or they go from 1 on without a gap.
/// Extended XYZ: the comment has Properties=NAME:TYPE:COUNT:...; species (element, Z), pos, type,
/// radius and color count; color is linear from 0 to 1 (type R) or 8-bit sRGB (type I). Others are
/// numbers on request: vectors as name_x, name_y, name_z, and their length as name. Lattice and
/// Origin are the cell; Time, or the step, the time.
Particles read_xyz(PackedFile& file, const ParticleRequest& request);

/// LAMMPS text dump. Columns x y z, else xu yu zu, else xs ys zs, else xsu ysu zsu (scaled by the
/// box: orthogonal, triclinic or general); radius or diameter; type; element; others are numbers on
/// request. The time is that of TIME, or else TIMESTEP.
Particles read_lammps(PackedFile& file, const ParticleRequest& request);

/// LAMMPS data file: section Atoms of a style with fixed columns, which the hint behind "Atoms"
/// names, or else the number of columns tells; elements by the masses of the types; the box.
Particles read_lammps_data(PackedFile& file, const ParticleRequest& request);

/// DCD (CHARMM, NAMD, X-PLOR, LAMMPS), of both byte orders, with fixed atoms and the cell in its
/// several forms. Format: CHARMM documentation, "dynamc", trajectory files. The time is that of
/// the frame's step.
Particles read_dcd(PackedFile& file, const ParticleRequest& request);

/// XTC and TRR of GROMACS; lengths in nm become angstrom.
Particles read_xtc(PackedFile& file, const ParticleRequest& request);
Particles read_trr(PackedFile& file, const ParticleRequest& request);

/// Trajectories and restart files of AMBER in classic netCDF (versions 1, 2 and 5).
Particles read_netcdf(PackedFile& file, const ParticleRequest& request);

/// Restart files of AMBER as text (inpcrd, rst7): a title, the number of atoms and the time, then
/// positions of 12 characters a number; velocities, if any; the box: AMBER file formats,
/// ambermd.org/FileFormats.php.
Particles read_inpcrd(PackedFile& file, const ParticleRequest& request);

// Names and elements without positions, all of which are 0.

/// PSF of CHARMM, X-PLOR and NAMD: section NATOM; elements by mass. Format: "PSF files",
/// NAMD tutorial, appendix; CHARMM documentation, "struct".
Particles read_psf(PackedFile& file, const ParticleRequest& request);

/// PRMTOP of AMBER: names, residues, charges, and elements by atomic number or mass. Format: "AMBER
/// file formats", ambermd.org/FileFormats.php.
Particles read_prmtop(PackedFile& file, const ParticleRequest& request);

/// Formats of molecules, in angstrom. All give the names of atoms, residues and chains that the
/// file has, and numbers where the request wants them. Types are the elements' symbols if the
/// format has none of its own. What the file leaves open is told by notes: elements are guessed by
/// residue and name (guess_element()), and of an atom's alternative locations those of the request
/// stay.

/// PDB as read_pdb_record() takes its records. Frames are models, or what END separates; CRYST1 is
/// the cell; numbers: occupancy, b_factor, charge (formal).
Particles read_pdb(PackedFile& file, const ParticleRequest& request);

/// PDBQT of AutoDock: as PDB, with the types, and charge as partial charge.
Particles read_pdbqt(PackedFile& file, const ParticleRequest& request);

/// PQR: as PDB, with radii and partial charges, fields separated by blanks. A radius of 0 becomes
/// the van der Waals radius.
Particles read_pqr(PackedFile& file, const ParticleRequest& request);

/// GRO of GROMACS (manual.gromacs.org, "gro"), any precision, several frames. Positions, which the
/// file gives in nanometres, become angstrom, so that van der Waals radii fit; velocities (vx, vy,
/// vz) become angstrom per picosecond. The box is the cell; "t=" of the title the time.
Particles read_gro(PackedFile& file, const ParticleRequest& request);

/// MOL and SDF, V2000 and V3000 ("CTfile Formats", BIOVIA, 2020). The molecules of an SDF are its
/// frames. Names and types are the symbols; numbers: charge (formal).
Particles read_sdf(PackedFile& file, const ParticleRequest& request);

/// MOL2 ("Tripos Mol2 File Format", 2009). Its molecules are the frames, CRYSIN the cell; numbers:
/// charge. Types are SYBYL's, or whatever stands there.
Particles read_mol2(PackedFile& file, const ParticleRequest& request);

/// CIF, of its first block that has atoms:
/// - mmCIF (_atom_site with Cartesian coordinates): models are frames; the cell; numbers:
/// occupancy,
///   b_factor, charge (formal);
/// - CIF of crystals (_atom_site with fractional coordinates): unit_cell(); numbers: occupancy,
///   b_factor (from U where the file gives that);
/// - components (_chem_comp_atom), with ideal coordinates where all atoms have them, else with the
///   model's; numbers: charge.
Particles read_cif(PackedFile& file, const ParticleRequest& request);

}  // namespace parray::input
