#include <algorithm>

#include "cli/input/formats/format_table.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/particle_columns.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Recognises a title, a count, and lines of six coordinates in the form 12.7.
Confidence looks_like_inpcrd(const FileStart& start) {
  constexpr std::size_t width = 12;
  constexpr std::size_t whole = 4;  // characters before the point
  const std::vector<std::string_view> head = words_of(start.line(1));
  if (head.empty() || head.size() > 3 || !is_natural(head[0])) return Confidence::none;
  if (!std::ranges::all_of(head, is_number)) return Confidence::none;
  const std::string_view row = start.line(2);
  if (row.size() < 3 * width || row.size() > 6 * width) return Confidence::none;
  for (std::size_t at = 0; at + width <= row.size(); at += width) {
    if (row[at + whole] != '.' || !is_number(trimmed(row.substr(at, width)))) {
      return Confidence::none;
    }
  }
  return Confidence::likely;
}

/// Reads the box. After the positions, the file has the same number of velocities or none, then six
/// numbers of the box or none.
std::optional<ParticleCell> box_in(const std::vector<double>& rest, std::size_t atoms) {
  constexpr std::size_t box_numbers = 6;
  const std::size_t velocities = rest.size() > box_numbers ? 3 * atoms : 0;
  if (rest.size() != velocities + box_numbers) return {};
  const double* const box = rest.data() + velocities;
  return cell_from({box[0], box[1], box[2]}, {box[3], box[4], box[5]});
}

/// Reads restart files of AMBER in text form: a title, the number of atoms and the time, positions
/// of 12 characters per number, optional velocities, an optional box. AMBER file formats,
/// ambermd.org/FileFormats.php.
Particles read_inpcrd(PackedFile& file, const ParticleRequest& /*request*/) {
  ParticleInput input(file);
  if (!input.next_line() || !input.next_line()) {
    input.fail_incomplete("the file has no number of atoms");
  }
  const std::vector<std::string_view> words = words_of(input.line());
  if (words.empty()) {
    input.fail("line 2 has no number of atoms: check that this is a restart file of AMBER");
  }
  const std::uint64_t count = count_field(words[0], input.place());
  const std::optional<double> time = words.size() > 1 ? number_in(words[1]) : std::nullopt;
  std::string_view row;  // the rest of the current line, which has at most six numbers
  const auto next = [&]() -> std::optional<double> {
    while (trimmed(row).empty()) {
      if (!input.next_line()) return {};
      row = input.line();
    }
    constexpr std::size_t width = 12;
    const std::string_view field = row.substr(0, width);
    row.remove_prefix(field.size());
    return number_field(trimmed(field), "number", input.place());
  };
  ParticleColumns columns(input.place());
  const auto take = [&] {
    const std::optional<double> number = next();
    if (!number) input.fail_incomplete("the file ends within its positions");
    return *number;
  };
  for (std::uint64_t i = 0; i < count; ++i) {
    const double x = take();
    const double y = take();
    columns.position({x, y, take()});
  }
  std::vector<double> rest;
  while (const std::optional<double> number = next()) rest.push_back(*number);
  Particles particles = columns.finish();
  particles.cell = box_in(rest, particles.count());
  particles.facts.time = time;
  return particles;
}

}  // namespace

constinit const ParticleFormat inpcrd_format{.name = "AMBER restart",
                                             .extensions = {".inpcrd", ".rst7", ".restrt"},
                                             .in_angstrom = true,
                                             .confidence = looks_like_inpcrd,
                                             .read = read_inpcrd,
                                             .holds = ParticleFormat::Holds::positions};

}  // namespace parray::input
