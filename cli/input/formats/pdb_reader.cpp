#include <array>
#include <optional>
#include <utility>

#include "cli/input/formats/atom_record.h"
#include "cli/input/formats/readers.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/frames.h"
#include "cli/input/particles/particle_input.h"
#include "cli/input/particles/particle_text.h"

namespace parray::input {
namespace {

/// What tells PDB, PDBQT and PQR apart.
struct Dialect {
  void (*read)(std::string_view line, const FilePlace& place, AtomRecord& record) = nullptr;
  bool radii = false;
};

constexpr Dialect pdb_dialect{read_pdb_record, false};
constexpr Dialect pdbqt_dialect{read_pdbqt_record, false};
constexpr Dialect pqr_dialect{read_pqr_record, true};

bool is_record(std::string_view line, std::string_view name) {
  return line.size() >= name.size() && lower_case(line.substr(0, name.size())) == name;
}

bool is_model(std::string_view line) {
  return is_record(line, "model") && (line.size() == 5 || line[5] == ' ' || line[5] == '\t');
}

bool ends_frame(std::string_view line) {
  if (line.empty() || (line[0] != 'E' && line[0] != 'e')) return false;
  return is_record(line, "endmdl") || lower_case(trimmed(line)) == "end";
}

/// CRYST1: lengths and angles, by columns. 1 x 1 x 1 stands for no cell (NMR and models).
std::optional<ParticleCell> cell_in(std::string_view line) {
  constexpr std::array<std::pair<std::size_t, std::size_t>, 6> fields{
      {{6, 9}, {15, 9}, {24, 9}, {33, 7}, {40, 7}, {47, 7}}};
  std::array<double, 6> values{};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto [start, width] = fields[i];
    if (line.size() <= start) return {};
    values[i] = number_in(trimmed(line.substr(start, width))).value_or(0);
  }
  const auto [a, b, c, alpha, beta, gamma] = values;
  if (a == 1 && b == 1 && c == 1) return {};
  return cell_from({a, b, c}, {alpha, beta, gamma});
}

/// A frame goes from MODEL, or from its first atom, to ENDMDL, END, the next MODEL or the end of
/// the file.
template <const Dialect& dialect>
class PdbFrames final : public FrameReader {
 public:
  PdbFrames(PackedFile& file, const ParticleRequest& request) : input_(file), request_(request) {
    go_to_frame();
  }

  bool next() override { return at_frame_; }

  std::uint64_t skip() override {
    std::uint64_t atoms = 0;
    while (go_to_atom()) ++atoms;
    go_to_frame();
    return atoms;
  }

  Particles read() override {
    AtomColumns atoms(input_.place(), request_, {"occupancy", "b_factor", "charge"});
    atoms.doubt_elements();
    AtomRecord record;
    while (go_to_atom()) {
      dialect.read(input_.line(), input_.place(), record);
      atoms.add(record.atom());
      atoms.numbers({{record.occupancy, record.b_factor, record.charge}});
      if (dialect.radii) atoms.radius(record.radius);
    }
    Particles particles = atoms.finish_frame();
    particles.cell = cell_;
    go_to_frame();
    if (!particles.cell) particles.cell = cell_;  // some programs write it behind the model
    return particles;
  }

  [[nodiscard]] const FilePlace& place() const override { return input_.place(); }

 private:
  /// The next atom of the frame; false at its end.
  bool go_to_atom() {
    if (std::exchange(line_is_next_, false)) {
      if (is_atom_record(input_.line())) return true;
    }
    while (!line_is_next_ && input_.next_line()) {
      if (is_atom_record(input_.line())) return true;
      if (ends_frame(input_.line())) return false;
      line_is_next_ = is_model(input_.line());
      look_for_cell();
    }
    return false;
  }

  /// To the MODEL or the first atom of the next frame.
  void go_to_frame() {
    at_frame_ = line_is_next_;
    while (!at_frame_ && input_.next_line()) {
      at_frame_ = is_atom_record(input_.line()) || is_model(input_.line());
      look_for_cell();
    }
    line_is_next_ = at_frame_;
  }

  void look_for_cell() {
    if (is_record(input_.line(), "cryst1")) cell_ = cell_in(input_.line());
  }

  ParticleInput input_;
  ParticleRequest request_;
  std::optional<ParticleCell> cell_;
  bool at_frame_ = false;
  bool line_is_next_ = false;  // of the frame: it has not been looked at
};

}  // namespace

Particles read_pdb(PackedFile& file, const ParticleRequest& request) {
  return read_frame<PdbFrames<pdb_dialect>>(file, request);
}

Particles read_pdbqt(PackedFile& file, const ParticleRequest& request) {
  return read_frame<PdbFrames<pdbqt_dialect>>(file, request);
}

Particles read_pqr(PackedFile& file, const ParticleRequest& request) {
  return read_frame<PdbFrames<pqr_dialect>>(file, request);
}

}  // namespace parray::input
