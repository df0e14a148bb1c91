#include <algorithm>
#include <array>

#include "cli/input/formats/format_table.h"
#include "cli/input/formats/notes.h"
#include "cli/input/formats/row_layout.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/length_unit.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::string_view item_mark = "ITEM: ";

Confidence looks_like_lammps_dump(const FileStart& start) {
  return certain_if(start.has(item_mark));
}

Vec3d at(const ParticleCell& box, const Vec3d& scaled) {
  return box.origin + scaled.x * box.edges[0] + scaled.y * box.edges[1] + scaled.z * box.edges[2];
}

struct DumpLayout {
  RowLayout row;
  bool scaled = false;
  std::optional<std::array<std::size_t, 3>> shape;  ///< diameters of ellipsoids along their axes
  bool oriented = false;
};

void next_data_line(ParticleInput& input) {
  if (!input.next_line()) input.fail_incomplete("the file ends within its header");
}

using BoxRows = std::array<std::array<double, 4>, 3>;

/// Reads the three lines of a box, each with `needed` numbers. `remedy` lists these numbers.
BoxRows read_box_rows(ParticleInput& input, std::size_t needed, const char* remedy) {
  BoxRows rows{};
  Fields fields;
  for (std::array<double, 4>& row : rows) {
    next_data_line(input);
    split_at_blanks(input.line(), fields);
    if (fields.size() != needed) {
      input.fail(std::to_string(fields.size()) + " numbers, but a line of the box needs " +
                 std::to_string(needed) + ": write " + remedy);
    }
    for (std::size_t i = 0; i < needed; ++i) {
      row[i] = number_field(fields[i], "box bound", input.place());
    }
  }
  return rows;
}

/// Reads a box. If it is tilted (xy, xz, yz), low and high are the bounds of the tilted box along x
/// and y: LAMMPS manual, "Triclinic (non-orthogonal) simulation boxes".
ParticleCell read_box(ParticleInput& input, bool tilted) {
  const BoxRows rows =
      read_box_rows(input, tilted ? 3 : 2, tilted ? "low, high and tilt" : "low, high");
  const double xy = rows[0][2];
  const double xz = rows[1][2];
  const double yz = rows[2][2];
  const auto [left, right] = std::minmax({0.0, xy, xz, xy + xz});
  const auto [front, back] = std::minmax({0.0, yz});
  const Vec3d low{rows[0][0] - left, rows[1][0] - front, rows[2][0]};
  const Vec3d high{rows[0][1] - right, rows[1][1] - back, rows[2][1]};
  return {low, {{{high.x - low.x, 0, 0}, {xy, high.y - low.y, 0}, {xz, yz, high.z - low.z}}}};
}

/// Reads a general triclinic box. Each line has an edge and a component of the origin.
ParticleCell read_general_box(ParticleInput& input) {
  const BoxRows rows = read_box_rows(input, 4, "an edge and a component of the origin");
  const auto edge = [&](std::size_t i) { return Vec3d{rows[i][0], rows[i][1], rows[i][2]}; };
  return {{rows[0][3], rows[1][3], rows[2][3]}, {edge(0), edge(1), edge(2)}};
}

/// Finds the columns of the first complete kind of position.
void find_position(const Fields& names, DumpLayout& layout, const FilePlace& place) {
  using Axes = std::array<std::string_view, 3>;
  constexpr std::array<Axes, 4> kinds{
      Axes{"x", "y", "z"}, {"xu", "yu", "zu"}, {"xs", "ys", "zs"}, {"xsu", "ysu", "zsu"}};
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const auto position = places_of_three(names, kinds[i]);
    if (!position) continue;
    layout.row.position = *position;
    layout.scaled = i >= 2;
    return;
  }
  place.fail("the dump has no positions: dump x y z, xu yu zu or xs ys zs");
}

/// `lower`: the names in lower case.
DumpLayout layout_of_dump(const Fields& names, const std::vector<std::string>& lower,
                          const FilePlace& place) {
  DumpLayout layout;
  find_position(names, layout, place);
  layout.row.type = place_in(names, "type");
  layout.row.element = place_in(names, "element");
  layout.row.radius = place_in(names, "radius");
  use_diameters(lower, layout.row);
  layout.shape = places_of_three(lower, {"shapex", "shapey", "shapez"});
  layout.oriented = place_in(lower, "quatw").has_value();
  return layout;
}

/// Returns whether the three diameters of a row are not all equal. In a table with orientations but
/// without diameters, every row is an ellipsoid.
bool is_ellipsoid_row(const Fields& row, const DumpLayout& layout) {
  if (!layout.shape) return layout.oriented;
  const auto& [x, y, z] = *layout.shape;
  return is_ellipsoid(row[x], row[y], row[z]);
}

/// The part of a frame before the particles.
struct DumpHeader {
  std::optional<std::uint64_t> count;
  std::optional<ParticleCell> box;
  std::optional<double> time;  ///< value of TIME or, without it, the time step
  std::string atoms;           ///< names of the columns
  std::string length_unit;     ///< that of UNITS; empty: unknown
};

/// Reads the boundaries "pp pp fs" at the end of an item. Without them, the box stays periodic.
void read_boundaries(std::string_view item, ParticleCell& box) {
  const Fields words = words_of(item);
  for (std::size_t i = 0; words.size() >= 3 && i < 3; ++i) {
    const std::string_view word = words[words.size() - 3 + i];
    constexpr std::string_view open = "fsm";  // fixed and two kinds of shrink-wrapped faces
    if (word.size() == 2 && open.find(word[0]) < open.size()) box.periodic.at(i) = false;
  }
}

/// Reads the item that begins on the current line.
void read_item(ParticleInput& input, DumpHeader& header) {
  const std::string item(trimmed(input.line().substr(item_mark.size())));
  if (item == "NUMBER OF ATOMS") {
    next_data_line(input);
    header.count = count_field(trimmed(input.line()), input.place());
  } else if (item.starts_with("BOX BOUNDS")) {
    const bool general = item.starts_with("BOX BOUNDS abc origin");
    header.box = general ? read_general_box(input)
                         : read_box(input, item.starts_with("BOX BOUNDS xy xz yz"));
    read_boundaries(item, *header.box);
  } else if (item == "TIMESTEP" || item == "TIME") {
    next_data_line(input);
    const std::optional<double> time = number_in(trimmed(input.line()));
    if (time && (item == "TIME" || !header.time)) header.time = time;
  } else if (item == "UNITS") {
    next_data_line(input);
    header.length_unit = length_unit_of_lammps(trimmed(input.line()));
  } else {
    input.fail("unknown item '" + printable(item) +
               "': check that this is a LAMMPS text dump of atoms");
  }
}

/// Reads the header of a frame from the current line on.
DumpHeader read_header(ParticleInput& input) {
  constexpr std::string_view atoms = "ITEM: ATOMS";
  DumpHeader header;
  do {
    const std::string_view line = input.line();
    if (!line.starts_with(item_mark)) {
      input.fail("'" + printable(line) +
                 "' is not a line 'ITEM: ...': check that this is a LAMMPS text dump");
    }
    if (line.starts_with(atoms)) {
      if (!header.count) {
        input.fail("the frame has no ITEM: NUMBER OF ATOMS before its atoms: add it");
      }
      header.atoms = line.substr(atoms.size());
      return header;
    }
    read_item(input, header);
  } while (input.next_line());
  input.fail_incomplete("the frame has no ITEM: ATOMS");
}

class DumpFrames final : public FramesOf<ParticleInput> {
 public:
  DumpFrames(PackedFile& file, const ParticleRequest& request) : FramesOf(file, request) {
    at_frame_ = input_.next_filled_line();
  }

  bool next() override {
    if (at_frame_) header_ = read_header(input_);
    if (!header_.length_unit.empty()) length_unit_ = header_.length_unit;
    return at_frame_;
  }

  std::uint64_t skip() override {
    input_.skip_rows(*header_.count);
    go_to_frame();
    return *header_.count;
  }

  Particles read() override {
    const Fields names = words_of(header_.atoms);
    const std::vector<std::string> lower = lower_case(names);
    DumpLayout layout = layout_of_dump(names, lower, input_.place());
    if (layout.scaled && !header_.box) {
      input_.fail("scaled positions need the box's bounds along x, y and z: dump x y z");
    }
    ParticleColumns columns(input_.place());
    const std::uint64_t least_row_bytes = 2 * names.size();
    columns.expect(std::min(*header_.count, input_.bytes_left().value_or(0) / least_row_bytes + 1));
    want_numbers(other_fields(lower, layout.row), request_, layout.row, columns);
    const std::uint64_t ellipsoids = read_rows(names.size(), layout, columns);
    go_to_frame();
    Particles particles = columns.finish_frame();
    add_note(particles.facts.notes, ellipsoids_note(ellipsoids));
    particles.facts.time = header_.time;
    particles.facts.length_unit = length_unit_;
    if (header_.box) particles.cell = valid_cell(*header_.box);
    return particles;
  }

 private:
  /// Reads the rows of the frame. Returns the number of ellipsoids.
  std::uint64_t read_rows(std::size_t width, const DumpLayout& layout, ParticleColumns& columns) {
    std::uint64_t ellipsoids = 0;
    Fields row;
    for (std::uint64_t i = 0; i < *header_.count; ++i) {
      input_.next_row(i, *header_.count, "atoms");
      split_at_blanks(input_.line(), row);
      if (row.size() != width) {
        input_.fail(std::to_string(row.size()) + " columns, but ITEM: ATOMS names " +
                    std::to_string(width) + ": use the same number");
      }
      const Vec3d position = position_of(row, layout.row, input_.place());
      columns.position(layout.scaled ? at(*header_.box, position) : position);
      add_attributes(row, layout.row, input_.place(), columns);
      ellipsoids += is_ellipsoid_row(row, layout) ? 1 : 0;
    }
    return ellipsoids;
  }

  void go_to_frame() {
    at_frame_ = input_.next_filled_line();
    if (at_frame_ && !input_.line().starts_with(item_mark)) {
      input_.fail(
          "text follows the last atom: correct the number of atoms in the header, or remove the "
          "text");
    }
  }

  bool at_frame_ = false;  // true: at the first line of the next frame
  DumpHeader header_;
  std::string length_unit_;  // UNITS is in the first frame only
};

}  // namespace

/// Reads LAMMPS dumps. Positions are the columns x y z, otherwise xu yu zu, otherwise xs ys zs,
/// otherwise xsu ysu zsu. The last two are scaled by the box (orthogonal, triclinic or general).
/// Also reads radius or diameter, type and element. Other columns are numbers on request. The time
/// is that of TIME or, without it, of TIMESTEP. A note counts ellipsoids.
constinit const ParticleFormat lammps_dump_format{.name = "LAMMPS dump",
                                                  .extensions = {".lammpstrj", ".dump"},
                                                  .frames = true,
                                                  .unordered = true,
                                                  .confidence = looks_like_lammps_dump,
                                                  .read = read_frame<DumpFrames>};

}  // namespace parray::input
