#include <stdexcept>
#include <utility>

#include "common/input/formats/atom_columns.h"
#include "common/input/formats/gemmi_seam.h"
#include "common/input/formats/readers.h"
#include "common/input/particles/frames.h"
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

/// A frame goes from one ENDMDL to the next; END ends the file.
class PdbFrames final : public FrameReader {
 public:
  PdbFrames(PackedFile& file, const ParticleRequest& /*request*/) : input_(file) { go_to_frame(); }

  bool next() override { return at_frame_; }

  std::uint64_t skip() override {
    std::uint64_t atoms = 0;
    while (go_to_atom()) ++atoms;
    go_to_frame();
    return atoms;
  }

  Particles read() override {
    AtomColumns atoms(input_.place());
    while (go_to_atom()) atoms.add(atom_in(input_.line(), input_.place()));
    go_to_frame();
    return atoms.finish_frame();
  }

  [[nodiscard]] const FilePlace& place() const override { return input_.place(); }

 private:
  [[nodiscard]] bool at_atom() const {
    return input_.line().starts_with("ATOM  ") || input_.line().starts_with("HETATM");
  }

  /// The next atom of the frame; false at its end.
  bool go_to_atom() {
    if (std::exchange(line_is_next_, false) && at_atom()) return true;
    while (input_.next_line() && !input_.line().starts_with("ENDMDL")) {
      if (at_atom()) return true;
      if (trimmed(input_.line()) == "END") break;
    }
    return false;
  }

  /// To the MODEL or the first atom of the next frame.
  void go_to_frame() {
    at_frame_ = false;
    while (!at_frame_ && input_.next_line() && trimmed(input_.line()) != "END") {
      at_frame_ = at_atom() || input_.line().starts_with("MODEL ");
    }
    line_is_next_ = at_frame_;
  }

  ParticleInput input_;
  bool at_frame_ = false;
  bool line_is_next_ = false;  // of the frame: it has not been looked at
};

}  // namespace

Particles read_pdb(PackedFile& file, const ParticleRequest& request) {
  return read_frame<PdbFrames>(file, request);
}

}  // namespace parray
