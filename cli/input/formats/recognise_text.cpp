#include <algorithm>
#include <string>

#include "cli/input/formats/recognisers.h"
#include "cli/input/particles/particle_text.h"

namespace parray::input {
namespace {

using Words = std::vector<std::string_view>;

Words words_of(std::string_view line, std::string_view separators = " \t") {
  Words words;
  while (true) {
    line.remove_prefix(std::min(line.find_first_not_of(separators), line.size()));
    if (line.empty()) return words;
    const std::size_t end = std::min(line.find_first_of(separators), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

bool is_number(std::string_view word) { return number_in(word).has_value(); }

/// Whether words `first` to `first + 2` are numbers.
bool three_numbers(const Words& words, std::size_t first) {
  return words.size() >= first + 3 &&
         std::all_of(words.begin() + static_cast<std::ptrdiff_t>(first),
                     words.begin() + static_cast<std::ptrdiff_t>(first) + 3, is_number);
}

bool is_count(std::string_view line) { return natural_in(trimmed(line)).has_value(); }

/// The first lines that are neither blank nor comments (#).
Words rows_of(const FileStart& start, std::size_t most) {
  Words rows;
  for (const std::string_view line : start.lines()) {
    if (trimmed(line).empty() || trimmed(line).starts_with('#')) continue;
    rows.push_back(line);
    if (rows.size() == most) break;
  }
  return rows;
}

}  // namespace

Likeness looks_like_ply(const FileStart& start) {
  return start.has("ply\n") || start.has("ply\r") ? Likeness::certain : Likeness::none;
}

Likeness looks_like_csv(const FileStart& start) {
  const Words rows = rows_of(start, 2);
  if (rows.empty()) return Likeness::none;
  constexpr std::string_view separators = " \t,;\"";
  const std::string header = lower_case(rows[0]);
  const Words names = words_of(header, separators);
  const auto has_name = [&](std::string_view name) { return std::ranges::count(names, name) > 0; };
  if (has_name("x") && has_name("y") && has_name("z")) return Likeness::likely;
  if (rows.size() < 2 || names.size() < 3) return Likeness::none;
  const Words fields = words_of(rows[1], separators);  // of a table whose columns have other names
  const auto numbers = std::ranges::count_if(fields, is_number);
  return fields.size() == names.size() && numbers >= 3 ? Likeness::possible : Likeness::none;
}

Likeness looks_like_xyz(const FileStart& start) {
  if (!is_count(start.line(0))) return Likeness::none;
  if (lower_case(start.line(1)).find("properties=") != std::string::npos) return Likeness::certain;
  const bool next_frame = is_count(start.line(2));  // after a frame without particles
  if (next_frame || three_numbers(words_of(start.line(2)), 1)) return Likeness::likely;
  return Likeness::possible;
}

Likeness looks_like_lammps_dump(const FileStart& start) {
  return start.has("ITEM: ") ? Likeness::certain : Likeness::none;
}

Likeness looks_like_lammps_data(const FileStart& start) {
  constexpr std::size_t header_lines = 40;
  bool atoms = false;
  bool box = false;
  for (std::size_t i = 1; i < header_lines; ++i) {  // the first line is a title
    const Words words = words_of(start.line(i));
    atoms = atoms || (words.size() >= 2 && is_count(words[0]) && words[1] == "atoms");
    box = box || (words.size() >= 4 && (words[2] == "xlo" || words[3] == "avec"));
  }
  return atoms && box ? Likeness::certain : Likeness::none;
}

Likeness looks_like_gro(const FileStart& start) {
  constexpr std::size_t names_end = 20;  // residue's number and name, atom's name and number
  if (!is_count(start.line(1))) return Likeness::none;
  const std::string_view atom = start.line(2);
  if (atom.size() <= names_end || !is_count(atom.substr(0, 5))) return Likeness::none;
  const std::string_view numbers = atom.substr(names_end);
  const std::size_t dot = numbers.find('.');
  const std::size_t next = dot == std::string_view::npos ? dot : numbers.find('.', dot + 1);
  if (next == std::string_view::npos) return Likeness::none;
  const std::size_t width = next - dot;  // of a coordinate: three decimals more than GROMACS's wish
  for (std::size_t i = 0; i < 3; ++i) {
    if (numbers.size() <= i * width) return Likeness::none;
    if (!is_number(trimmed(numbers.substr(i * width, width)))) return Likeness::none;
  }
  return Likeness::likely;
}

Likeness looks_like_inpcrd(const FileStart& start) {
  constexpr std::size_t width = 12;
  constexpr std::size_t whole = 4;  // of it before the point
  const Words head = words_of(start.line(1));
  if (head.empty() || head.size() > 3 || !is_count(head[0])) return Likeness::none;
  if (!std::ranges::all_of(head, is_number)) return Likeness::none;
  const std::string_view row = start.line(2);
  if (row.size() < 3 * width || row.size() > 6 * width) return Likeness::none;
  for (std::size_t at = 0; at + width <= row.size(); at += width) {
    if (row[at + whole] != '.' || !is_number(trimmed(row.substr(at, width)))) return Likeness::none;
  }
  return Likeness::likely;
}

}  // namespace parray::input
