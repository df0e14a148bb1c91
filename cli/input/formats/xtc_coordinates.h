#pragma once

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "common/math/vec.h"

namespace parray::input {

/// What stands before the packed coordinates of a frame.
struct XtcPacking {
  std::uint64_t atoms = 0;
  double precision = 0;  ///< coordinates are whole numbers of 1 / precision
  std::array<std::int32_t, 3> least{};
  std::array<std::int32_t, 3> most{};
  std::int32_t small = 0;  ///< which size of small differences comes first
};

/// The positions, in nm, that GROMACS has packed into `bytes`. Each is a whole number within the
/// box of `least` and `most`, written as one number in a mixed base, or the difference to the
/// position before it, whose size changes on the way; a bit, and sometimes a count of differences
/// after it, say which. The first difference after a whole position belongs to the atom before:
/// water has its oxygen, the middle of the molecule, written first. Format: GROMACS manual, "File
/// formats", xtc; Green, "xdrf library", EMBL 1995; Spångberg, Larsson and van der Spoel, J. Mol.
/// Model. 17 (2011) 2669.
///
/// Fails at `place` for what is damaged, before anything is allocated for more than there is.
std::vector<Vec3d> unpack_xtc(const XtcPacking& packing, std::string_view bytes,
                              const FilePlace& place);

}  // namespace parray::input
