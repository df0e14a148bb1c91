#pragma once

#include "common/input/particles/packed_file.h"
#include "common/input/particles/particles.h"

/// One reader a format. All throw InputError as read_particles() does. Those of formats that hold
/// several frames read the one that the request chooses.
namespace parray {

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
/// The name is a symbol, an atomic number or any other (element unknown).
/// Extended XYZ: the comment has Properties=NAME:TYPE:COUNT:..., of which species, pos, radius and
/// color count; color is linear from 0 to 1 (type R) or 8-bit sRGB (type I). Lattice is ignored.
Particles read_xyz(PackedFile& file, const ParticleRequest& request);

/// LAMMPS text dump. Columns x y z, else xu yu zu, else xs ys zs, else xsu ysu zsu (scaled by the
/// box, orthogonal or triclinic); radius or diameter; type; element.
Particles read_lammps(PackedFile& file, const ParticleRequest& request);

/// PDB: ATOM and HETATM records of one model. Of an atom's alternative locations the one with
/// the highest occupancy stays (the first of equals). Types are the elements' symbols.
Particles read_pdb(PackedFile& file, const ParticleRequest& request);

/// mmCIF: the first _atom_site category, as read_pdb().
Particles read_mmcif(PackedFile& file, const ParticleRequest& request);

}  // namespace parray
