#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "cli/input/formats/format_table.h"
#include "cli/input/formats/pdb_record.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/frames.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

bool is_number_field(std::string_view text) { return number_in(trimmed(text)).has_value(); }

/// Returns columns `first` to `last`, counted from 1 as in the description of PDB.
std::string_view columns(std::string_view line, std::size_t first, std::size_t last) {
  return line.size() < first ? std::string_view() : line.substr(first - 1, last - first + 1);
}

bool is_atom(std::string_view line) {
  return line.starts_with("ATOM ") || line.starts_with("ATOM\t") || line.starts_with("HETATM");
}

/// Returns the first line of an atom. Returns "" if there is none.
std::string_view first_atom(const FileStart& start) {
  const auto found = std::ranges::find_if(start.lines(), is_atom);
  return found == start.lines().end() ? std::string_view() : *found;
}

bool is_record_of_pdb(std::string_view line) {
  constexpr std::array<std::string_view, 39> names{
      "HEADER", "OBSLTE", "TITLE",  "SPLIT",  "CAVEAT", "COMPND", "SOURCE", "KEYWDS",
      "EXPDTA", "NUMMDL", "MDLTYP", "AUTHOR", "REVDAT", "SPRSDE", "JRNL",   "REMARK",
      "DBREF",  "DBREF1", "DBREF2", "SEQADV", "SEQRES", "MODRES", "HETNAM", "HETSYN",
      "FORMUL", "HELIX",  "SHEET",  "SSBOND", "LINK",   "CISPEP", "SITE",   "CRYST1",
      "ORIGX1", "ORIGX2", "ORIGX3", "SCALE1", "SCALE2", "SCALE3", "MODEL"};
  const std::string_view name = trimmed(columns(line, 1, 6));
  return std::ranges::find(names, name) != names.end();
}

bool has_two_decimals(std::string_view number) {
  return number.size() > 3 && number[number.size() - 3] == '.' && is_number_field(number);
}

/// Returns whether a text is an occupancy and a temperature factor in PDB's form: "  1.00 20.00".
/// Either may be missing.
bool is_occupancy_and_factor(std::string_view tail) {
  const std::string_view occupancy = trimmed(columns(tail, 1, 6));
  const std::string_view factor = trimmed(columns(tail, 7, 12));
  return (occupancy.empty() || has_two_decimals(occupancy)) &&
         (factor.empty() || has_two_decimals(factor));
}

bool has_position_of_pdb(std::string_view atom) {
  return is_number_field(columns(atom, 31, 38)) && is_number_field(columns(atom, 39, 46)) &&
         is_number_field(columns(atom, 47, 54));
}

/// Recognises PDBQT (AutoDock Vina's manual): PDB with charges in columns 71 to 76 and with roots
/// and branches.
Confidence looks_like_pdbqt(const FileStart& start) {
  const std::string_view atom = first_atom(start);
  if (atom.empty() || !has_position_of_pdb(atom)) return Confidence::none;
  if (start.has_line("ROOT") || start.has_line("ENDROOT")) return Confidence::certain;
  const std::string_view charge = trimmed(columns(atom, 69, 76));
  const bool has_charge = is_number_field(charge) && charge.find('.') != std::string_view::npos;
  return certain_if(has_charge && !trimmed(columns(atom, 78, 79)).empty());
}

/// Recognises PDB (wwPDB, "Protein Data Bank Contents Guide", version 3.30).
Confidence looks_like_pdb(const FileStart& start) {
  const std::string_view atom = first_atom(start);
  if (atom.empty()) {
    const auto records = std::ranges::count_if(start.lines(), is_record_of_pdb);
    if (!is_record_of_pdb(start.line(0))) return Confidence::none;
    if (trimmed(start.line(0)) == "TITLE")
      return Confidence::none;  // GROMOS96; the record TITLE of PDB has a text
    const bool most = records >= 3 && 2 * records > std::ssize(start.lines());
    return most ? Confidence::likely : Confidence::possible;
  }
  if (!has_position_of_pdb(atom) || looks_like_pdbqt(start) == Confidence::certain ||
      !is_occupancy_and_factor(columns(atom, 55, 66))) {
    return Confidence::possible;
  }
  return Confidence::likely;
}

/// Recognises PQR (APBS's manual): PDB with blanks between fields and with a charge and a radius at
/// the end of the line.
Confidence looks_like_pqr(const FileStart& start) {
  const std::string_view atom = first_atom(start);
  const std::vector<std::string_view> words = words_of(atom);
  constexpr std::size_t least = 9;  // without chain and residue name
  constexpr std::size_t most = 11;
  constexpr std::size_t numbers = 5;  // position, charge, radius
  if (words.size() < least || words.size() > most ||
      !std::all_of(words.end() - numbers, words.end(), is_number_field)) {
    return Confidence::none;
  }
  const bool as_pdb = has_position_of_pdb(atom) && is_occupancy_and_factor(columns(atom, 55, 66));
  const bool as_occupancy = has_two_decimals(words[words.size() - 2]);
  return as_pdb || as_occupancy ? Confidence::possible : Confidence::likely;
}

/// The differences between PDB, PDBQT and PQR.
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

/// Reads lengths and angles from the columns of CRYST1. A cell of 1 x 1 x 1 is a placeholder (NMR
/// and models).
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

/// Reads frames. A frame begins with MODEL or its first atom. It ends with ENDMDL, END, the next
/// MODEL or the end of the file.
template <const Dialect& dialect>
class PdbFrames final : public FramesOf<ParticleInput> {
 public:
  PdbFrames(PackedFile& file, const ParticleRequest& request) : FramesOf(file), request_(request) {
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
    if (!particles.cell) particles.cell = cell_;  // some programs write CRYST1 after the model
    return particles;
  }

 private:
  /// Goes to the next atom of the frame. Returns false at the end of the frame.
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

  /// Goes to the MODEL or the first atom of the next frame.
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

  ParticleRequest request_;
  std::optional<ParticleCell> cell_;
  bool at_frame_ = false;
  bool line_is_next_ = false;  // true: the current line belongs to the frame and was not read yet
};

/// Reads PDB records with read_pdb_record(). Models are frames; END also separates frames. CRYST1
/// is the cell. Numbers: occupancy, b_factor, charge (formal).
Particles read_pdb(PackedFile& file, const ParticleRequest& request) {
  return read_frame<PdbFrames<pdb_dialect>>(file, request);
}

/// Reads PDBQT of AutoDock: like PDB, with AutoDock's types and partial charges.
Particles read_pdbqt(PackedFile& file, const ParticleRequest& request) {
  return read_frame<PdbFrames<pdbqt_dialect>>(file, request);
}

/// Reads PQR: like PDB, with radii and partial charges and with blanks between fields. A radius of
/// 0 becomes the van der Waals radius.
Particles read_pqr(PackedFile& file, const ParticleRequest& request) {
  return read_frame<PdbFrames<pqr_dialect>>(file, request);
}

}  // namespace

constinit const ParticleFormat pdb_format{.name = "PDB",
                                          .extensions = {".pdb", ".ent", ".pdb1"},
                                          .frames = true,
                                          .confidence = looks_like_pdb,
                                          .read = read_pdb};

constinit const ParticleFormat pdbqt_format{.name = "PDBQT",
                                            .extensions = {".pdbqt"},
                                            .frames = true,
                                            .confidence = looks_like_pdbqt,
                                            .read = read_pdbqt};

constinit const ParticleFormat pqr_format{.name = "PQR",
                                          .extensions = {".pqr"},
                                          .frames = true,
                                          .confidence = looks_like_pqr,
                                          .read = read_pqr};

}  // namespace parray::input
