#include <algorithm>
#include <stdexcept>

#include "common/input/formats/atom_columns.h"
#include "common/input/formats/gemmi_seam.h"
#include "common/input/formats/readers.h"
#include "common/input/particles/particle_input.h"
#include "common/input/particles/particle_text.h"

namespace parray {
namespace {

/// gemmi takes what is no number for 0, so the coordinates are read here: columns 31 to 54.
Vec3d position_in(std::string_view record, const FilePlace& place) {
  constexpr std::size_t start = 30;
  constexpr std::size_t width = 8;
  if (record.size() < start + 3 * width) {
    place.fail("the record ends before its coordinates, columns 31 to 54: is it complete?");
  }
  const auto field = [&](std::size_t i, std::string_view name) {
    return number_field(trimmed(record.substr(start + i * width, width)), name, place);
  };
  const double x = field(0, "x");
  const double y = field(1, "y");
  return {x, y, field(2, "z")};
}

PdbAtom parsed(std::string_view record, const FilePlace& place) {
  try {
    return parse_pdb_atom(std::string(record));
  } catch (const std::runtime_error&) {
    place.fail("not a record of an atom: is a column damaged?");
  }
}

Atom atom_in(std::string_view record, const FilePlace& place) {
  const Vec3d position = position_in(record, place);
  const PdbAtom atom = parsed(record, place);
  return {position,
          static_cast<std::uint8_t>(atom.atomic_number),
          atom.chain + '\0' + atom.residue_number,
          atom.residue_name,
          atom.name,
          atom.alternative_location,
          atom.occupancy};
}

/// Passes over so many models.
void skip_models(ParticleInput& input, std::uint64_t models) {
  for (std::uint64_t model = 0; model < models;) {
    if (!input.next_line() || trimmed(input.line()) == "END") {
      input.fail_without_frame(std::max<std::uint64_t>(model, 1), models);
    }
    model += input.line().starts_with("ENDMDL") ? 1 : 0;
  }
}

}  // namespace

Particles read_pdb(PackedFile& file, const ParticleRequest& request) {
  ParticleInput input(file);
  const std::uint64_t frame = request.frame_number();
  skip_models(input, frame);
  AtomColumns atoms(input.place());
  bool empty = true;
  while (input.next_line()) {
    const std::string_view line = input.line();
    if (line.starts_with("ATOM  ") || line.starts_with("HETATM")) {
      empty = false;
      atoms.add(atom_in(line, input.place()));
    } else if (line.starts_with("ENDMDL") || trimmed(line) == "END") {
      break;
    }
  }
  if (empty && frame > 0) input.fail_without_frame(frame, frame);
  return atoms.finish();
}

}  // namespace parray
