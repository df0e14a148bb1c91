#include <algorithm>
#include <array>

#include "common/base/printable.h"
#include "common/input/formats/readers.h"
#include "common/input/formats/row_layout.h"
#include "common/input/particles/particle_input.h"
#include "common/input/particles/particle_text.h"

namespace parray {
namespace {

constexpr std::string_view item_mark = "ITEM: ";

/// The simulation box: its origin and edges a, b, c (a along x, b in the xy plane).
struct Box {
  Vec3d origin;
  Vec3d a;
  Vec3d b;
  Vec3d c;

  Vec3d at(const Vec3d& scaled) const {
    return origin + scaled.x * a + scaled.y * b + scaled.z * c;
  }
};

struct DumpLayout {
  RowLayout row;
  bool scaled = false;
};

void next_data_line(ParticleInput& input) {
  if (!input.next_line()) input.fail("the file ends within its header: is it complete?");
}

/// The box from three lines "low high [tilt]". With tilts (xy, xz, yz), low and high bound the
/// tilted box along x and y: LAMMPS manual, "Triclinic simulation boxes".
Box read_box(ParticleInput& input, bool tilted) {
  std::array<std::array<double, 3>, 3> rows{};
  Fields fields;
  for (std::array<double, 3>& row : rows) {
    next_data_line(input);
    split_at_blanks(input.line(), fields);
    const std::size_t needed = tilted ? 3 : 2;
    if (fields.size() != needed) {
      input.fail(std::to_string(fields.size()) + " numbers where the box needs " +
                 std::to_string(needed) + ": write low, high" + (tilted ? " and tilt" : ""));
    }
    for (std::size_t i = 0; i < needed; ++i) {
      row[i] = number_field(fields[i], "box bound", input.place());
    }
  }
  const double xy = rows[0][2];
  const double xz = rows[1][2];
  const double yz = rows[2][2];
  const auto [left, right] = std::minmax({0.0, xy, xz, xy + xz});
  const auto [front, back] = std::minmax({0.0, yz});
  const Vec3d low{rows[0][0] - left, rows[1][0] - front, rows[2][0]};
  const Vec3d high{rows[0][1] - right, rows[1][1] - back, rows[2][1]};
  return {low, {high.x - low.x, 0, 0}, {xy, high.y - low.y, 0}, {xz, yz, high.z - low.z}};
}

std::optional<std::size_t> column_of(const Fields& names, std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return {};
  return static_cast<std::size_t>(found - names.begin());
}

/// Columns of the first kind of position that is complete.
void find_position(const Fields& names, DumpLayout& layout, const FilePlace& place) {
  struct Kind {
    std::array<std::string_view, 3> axes;
    bool scaled;
  };
  constexpr std::array<Kind, 4> kinds{{{{"x", "y", "z"}, false},
                                       {{"xu", "yu", "zu"}, false},
                                       {{"xs", "ys", "zs"}, true},
                                       {{"xsu", "ysu", "zsu"}, true}}};
  for (const Kind& kind : kinds) {
    const auto x = column_of(names, kind.axes[0]);
    const auto y = column_of(names, kind.axes[1]);
    const auto z = column_of(names, kind.axes[2]);
    if (!x || !y || !z) continue;
    layout.row.position = {*x, *y, *z};
    layout.scaled = kind.scaled;
    return;
  }
  place.fail("no positions: dump x y z, xu yu zu or xs ys zs");
}

DumpLayout layout_of_dump(const Fields& names, const FilePlace& place) {
  DumpLayout layout;
  find_position(names, layout, place);
  layout.row.type = column_of(names, "type");
  layout.row.element = column_of(names, "element");
  layout.row.radius = column_of(names, "radius");
  if (!layout.row.radius) {
    layout.row.radius = column_of(names, "diameter");
    layout.row.radius_factor = 0.5;
  }
  return layout;
}

/// What stands before the particles.
struct DumpHeader {
  std::optional<std::uint64_t> count;
  std::optional<Box> box;
  std::string atoms;  ///< names of the columns
};

/// Reads the item that the current line starts.
void read_item(ParticleInput& input, DumpHeader& header) {
  const std::string item(trimmed(input.line().substr(item_mark.size())));
  if (item == "NUMBER OF ATOMS") {
    next_data_line(input);
    header.count = count_field(trimmed(input.line()), input.place());
  } else if (item.starts_with("BOX BOUNDS abc origin")) {
    for (int i = 0; i < 3; ++i) next_data_line(input);  // general edges; only scaled ones need it
  } else if (item.starts_with("BOX BOUNDS")) {
    header.box = read_box(input, item.starts_with("BOX BOUNDS xy xz yz"));
  } else if (item == "TIMESTEP" || item == "TIME" || item == "UNITS") {
    next_data_line(input);
  } else {
    input.fail("unknown item '" + printable(item) + "': is this a LAMMPS text dump of atoms?");
  }
}

/// From the current line on.
DumpHeader read_header(ParticleInput& input) {
  constexpr std::string_view atoms = "ITEM: ATOMS";
  DumpHeader header;
  do {
    const std::string_view line = input.line();
    if (!line.starts_with(item_mark)) {
      input.fail("'" + printable(line) +
                 "' where a line 'ITEM: ...' should be: is this a LAMMPS "
                 "text dump?");
    }
    if (line.starts_with(atoms)) {
      if (!header.count) input.fail("no ITEM: NUMBER OF ATOMS before the atoms: add it");
      header.atoms = line.substr(atoms.size());
      return header;
    }
    read_item(input, header);
  } while (input.next_line());
  input.fail("no ITEM: ATOMS: is the file complete?");
}

/// Passes over so many frames, to the first line of the next.
void skip_frames(ParticleInput& input, std::uint64_t frames) {
  for (std::uint64_t frame = 0; frame < frames; ++frame) {
    const DumpHeader header = read_header(input);
    for (std::uint64_t i = 0; i < *header.count; ++i) {
      if (!input.next_line()) input.fail("the file ends within a frame: is it complete?");
    }
    if (!input.next_filled_line()) input.fail_without_frame(frame + 1, frames);
  }
}

void read_rows(ParticleInput& input, const DumpHeader& header, std::size_t width,
               const DumpLayout& layout, ParticleColumns& columns) {
  Fields row;
  for (std::uint64_t i = 0; i < *header.count; ++i) {
    if (!input.next_line()) {
      input.fail("the file ends after " + std::to_string(i) + " of " +
                 std::to_string(*header.count) + " atoms: is it complete?");
    }
    split_at_blanks(input.line(), row);
    if (row.size() != width) {
      input.fail(std::to_string(row.size()) + " columns where ITEM: ATOMS names " +
                 std::to_string(width) + ": write as many");
    }
    const Vec3d position = position_of(row, layout.row, input.place());
    columns.position(layout.scaled ? header.box->at(position) : position);
    add_attributes(row, layout.row, input.place(), columns);
  }
}

}  // namespace

Particles read_lammps(PackedFile& file, const ParticleRequest& request) {
  ParticleInput input(file);
  if (!input.next_line()) input.fail("no ITEM: ATOMS: is the file complete?");
  skip_frames(input, request.frame_number());
  const DumpHeader header = read_header(input);
  Fields names;
  split_at_blanks(header.atoms, names);
  const DumpLayout layout = layout_of_dump(names, input.place());
  if (layout.scaled && !header.box) {
    input.fail("scaled positions need the box's bounds along x, y and z: dump x y z");
  }
  ParticleColumns columns(input.place());
  const std::uint64_t least_row_bytes = 2 * names.size();
  columns.expect(std::min(*header.count, input.bytes_left().value_or(0) / least_row_bytes + 1));
  read_rows(input, header, names.size(), layout, columns);
  if (input.next_filled_line() && !input.line().starts_with(item_mark)) {
    input.fail("text after the last atom: is ITEM: NUMBER OF ATOMS right?");
  }
  return columns.finish();
}

}  // namespace parray
