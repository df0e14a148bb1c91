#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "cli/input/formats/format_table.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/guess_element.h"
#include "cli/input/particles/particle_columns.h"
#include "cli/input/particles/particle_input.h"
#include "common/base/ascii.h"
#include "common/base/printable.h"
#include "common/base/text.h"

/// Files of VASP: POSCAR, CONTCAR, XDATCAR and, up to their atoms, CHGCAR and LOCPOT. Format: VASP
/// wiki, "POSCAR" and "XDATCAR".
namespace parray::input {
namespace {

using LineWords = std::vector<std::string_view>;

/// Returns the words before a comment, which begins with "!" or "#".
LineWords words_before_comment(std::string_view line) {
  return words_of(line.substr(0, line.find_first_of("!#")));
}

std::size_t leading_numbers(std::string_view line) {
  const LineWords words = words_of(line);
  const auto first_text = std::ranges::find_if_not(words, is_number);
  return static_cast<std::size_t>(first_text - words.begin());
}

bool are_counts(const LineWords& words) {
  return !words.empty() && std::ranges::all_of(words, is_natural);
}

/// Returns whether the words are names of species: "Na_pv", "O".
bool are_species(const LineWords& words) {
  return !words.empty() && std::ranges::all_of(words, [](std::string_view word) {
    return ascii::is_letter(word[0]);
  });
}

/// Returns the first letter of the line in lower case; 0 for another character or a blank line.
char first_letter(std::string_view line) {
  const std::string_view text = trimmed(line);
  return text.empty() || !ascii::is_letter(text[0]) ? '\0' : ascii::lower(text[0]);
}

/// Returns whether the line begins a frame of XDATCAR: "Direct configuration=     1".
bool is_configuration(std::string_view line) {
  constexpr std::string_view letters = "cdk";
  return letters.find(first_letter(line)) < letters.size() &&
         lower_case(line).find("configuration=") != std::string::npos;
}

Confidence looks_like_poscar(const FileStart& start) {
  const std::size_t factors = leading_numbers(start.line(1));
  if (factors != 1 && factors != 3) return Confidence::none;
  for (std::size_t i = 2; i <= 4; ++i) {
    if (leading_numbers(start.line(i)) < 3) return Confidence::none;
  }
  const bool names = are_species(words_before_comment(start.line(5)));
  const std::size_t counts = names ? 6 : 5;
  if (!are_counts(words_before_comment(start.line(counts)))) return Confidence::none;
  if (leading_numbers(start.line(counts + 1)) > 0) return Confidence::none;  // a table of numbers
  constexpr std::string_view modes = "scdk";
  const bool known = modes.find(first_letter(start.line(counts + 1))) < modes.size();
  return known ? Confidence::certain : Confidence::likely;
}

/// Returns the symbol in the name of a species: "Na_pv", "H.75", "Fe2" and "O/6a2f546d" name Na, H,
/// Fe and O.
std::string_view symbol_in(std::string_view species) {
  const auto* const end = std::ranges::find_if_not(species, ascii::is_letter);
  return species.substr(0, static_cast<std::size_t>(end - species.begin()));
}

/// Splits "NaCl", "H2O" or "Fe" into symbols. Returns none if the word is not a chemical formula.
std::vector<std::string> symbols_in(std::string_view word) {
  std::vector<std::string> symbols;
  for (const char c : word) {
    if (ascii::is_upper(c)) {
      symbols.emplace_back(1, c);
    } else if (symbols.empty() || (!ascii::is_letter(c) && !ascii::is_digit(c))) {
      return {};
    } else {
      symbols.back() += c;
    }
  }
  for (std::string& symbol : symbols) {
    symbol.resize(symbol_in(symbol).size());
    if (atomic_number_of(symbol) == 0) return {};
  }
  return symbols;
}

/// Returns the species that the title of a file of VASP 4 names by convention ("Na Cl", "NaCl
/// bulk"). Returns none unless their number is `count`.
std::vector<std::string> species_in_title(std::string_view title, std::size_t count) {
  std::vector<std::string> species;
  for (const std::string_view word : words_of(title)) {
    const std::vector<std::string> symbols = symbols_in(word);
    if (symbols.empty()) break;
    species.insert(species.end(), symbols.begin(), symbols.end());
  }
  return species.size() == count ? species : std::vector<std::string>{};
}

/// The lines before the positions.
struct PoscarHeader {
  Vec3d scale;  ///< factors of the components of edges and Cartesian positions
  std::array<Vec3d, 3> edges;
  std::vector<std::string> species;   ///< one per count
  std::vector<std::uint64_t> counts;  ///< atoms of each species
  std::uint64_t atoms = 0;
  bool named = false;       ///< true: the file or its title names the species
  bool from_title = false;  ///< true: the title names them
  bool selective = false;   ///< true: three flags follow each position
};

class PoscarHeaderReader {
 public:
  explicit PoscarHeaderReader(ParticleInput& input) : input_(input) {}

  /// Reads the header. Its title is the current line of the input. Leaves the input at the line
  /// that states the mode of the positions.
  PoscarHeader read() {
    const std::string title(input_.line());
    read_lattice();
    next_line();
    LineWords words = words_before_comment(input_.line());
    if (are_species(words)) {
      header_.named = true;
      for (const std::string_view word : words) {
        header_.species.emplace_back(word.substr(0, word.find('/')));
      }
      next_line();
      words = words_before_comment(input_.line());
    }
    read_counts(words);
    if (!header_.named) {  // the title names the species; otherwise they are numbers from 1
      header_.species = species_in_title(title, header_.counts.size());
      header_.named = header_.from_title = !header_.species.empty();
      for (std::size_t i = header_.species.size(); i < header_.counts.size(); ++i) {
        header_.species.push_back(std::to_string(i + 1));
      }
    }
    next_line();
    header_.selective = first_letter(input_.line()) == 's';
    if (header_.selective) next_line();
    return std::move(header_);
  }

 private:
  void next_line() {
    if (input_.next_line()) return;
    input_.fail_incomplete("the file ends within its header");
  }

  /// Reads the scale and the edges. A negative scale is the volume of the cell.
  void read_lattice() {
    next_line();
    const std::size_t factors = leading_numbers(input_.line());
    if (factors != 1 && factors != 3) {
      input_.fail(std::to_string(factors) +
                  " scale factors: write one number, or three positive numbers");
    }
    const LineWords words = words_of(input_.line());
    const double first = number_field(words[0], "scale factor", input_.place());
    const Vec3d scale =
        factors == 1 ? Vec3d{first, first, first} : position_field(words, 0, input_.place());
    if (factors == 3 && !(first > 0 && scale.y > 0 && scale.z > 0)) {
      input_.fail("three scale factors must be positive: write positive numbers");
    }
    if (first == 0) {
      input_.fail(
          "the scale factor is 0: write a positive number, or the volume of the cell with a minus "
          "sign");
    }
    for (Vec3d& edge : header_.edges) {
      next_line();
      const LineWords vector = words_of(input_.line());
      if (vector.size() < 3) {
        input_.fail(std::to_string(vector.size()) +
                    " numbers, but 3 are needed: write a vector of the lattice");
      }
      edge = position_field(vector, 0, input_.place());
    }
    const auto& [a, b, c] = header_.edges;
    const double volume = std::abs(dot(a, cross(b, c)));
    const double side = std::cbrt(std::abs(first) / volume);
    header_.scale = first < 0 ? Vec3d{side, side, side} : scale;
    for (Vec3d& edge : header_.edges) edge = header_.scale * edge;
    if (!valid_cell({{}, header_.edges})) {
      input_.fail("the three vectors of the lattice span no volume: correct them");
    }
  }

  void read_counts(const LineWords& words) {
    if (!are_counts(words)) {
      input_.fail("'" + printable(input_.line()) +
                  "' are not numbers of atoms: write one whole number per species");
    }
    if (header_.named && words.size() != header_.species.size()) {
      input_.fail(std::to_string(words.size()) + " numbers of atoms, but " +
                  std::to_string(header_.species.size()) +
                  " species: write one whole number per species");
    }
    for (const std::string_view word : words) {
      header_.counts.push_back(count_field(word, input_.place()));
      header_.atoms += header_.counts.back();
      count_field(std::to_string(header_.atoms), input_.place());
    }
  }

  ParticleInput& input_;
  PoscarHeader header_;
};

constexpr std::array<std::string_view, 3> velocity_names{"vx", "vy", "vz"};

class PoscarFrames final : public FramesOf<ParticleInput> {
 public:
  PoscarFrames(PackedFile& file, const ParticleRequest& request)
      : FramesOf(file, request), at_frame_(input_.next_line()) {}

  bool next() override {
    if (!at_frame_ || at_row_) return at_frame_;
    if (!trajectory_ || !is_configuration(input_.line())) {
      header_ = PoscarHeaderReader(input_).read();
    }
    read_mode();
    return true;
  }

  std::uint64_t skip() override {
    input_.skip_rows(header_.atoms - (at_row_ && header_.atoms > 0 ? 1 : 0));
    go_to_frame();
    return header_.atoms;
  }

  Particles read() override {
    ParticleColumns columns(input_.place());
    columns.expect(std::min(header_.atoms, input_.bytes_left().value_or(0) / least_row_bytes + 1));
    for (std::size_t i = 0; i < header_.counts.size(); ++i) read_species(i, columns);
    Particles particles = columns.finish_frame();
    if (!trajectory_) read_velocities(particles);
    go_to_frame();
    add_notes(particles);
    particles.cell = ParticleCell{{}, header_.edges};
    particles.facts.time = configuration_;
    return particles;
  }

 private:
  static constexpr std::uint64_t least_row_bytes = 6;  // "0 0 0\n"

  /// Reads the current line, which states the mode of the positions: Direct or Cartesian. In
  /// XDATCAR the line also has the number of the frame. In XDATCAR of VASP 5.2 it is blank.
  void read_mode() {
    const std::string_view line = input_.line();
    const char letter = first_letter(line);
    const bool blank = trimmed(line).empty();
    if (letter == '\0' && !blank) {
      input_.fail("'" + printable(line) +
                  "' is not the mode of the positions: write Direct or Cartesian");
    }
    cartesian_ = is_cartesian(letter);
    trajectory_ = blank || is_configuration(line);
    separated_by_blanks_ = blank;
    if (blank) {
      at_row_ = input_.next_filled_line();
    } else if (trajectory_) {
      configuration_ = number_in(trimmed(line.substr(line.find('=') + 1)));
    }
  }

  static bool is_cartesian(char letter) { return letter == 'c' || letter == 'k'; }

  void read_species(std::size_t number, ParticleColumns& columns) {
    for (std::uint64_t i = 0; i < header_.counts[number]; ++i) {
      const Vec3d numbers = next_three("atoms");
      columns.position(cartesian_ ? header_.scale * numbers : in_cell(numbers));
      const std::string_view species = species_of_row(header_.species[number]);
      const std::uint8_t element =
          header_.named || named_by_rows_ ? atomic_number_of(symbol_in(species)) : 0;
      element == 0 ? columns.unknown_element() : columns.element(element);
      columns.type(species);
    }
  }

  /// Returns the symbol after the position in the current row. Returns `species` if there is none,
  /// or if the header lists the species.
  std::string_view species_of_row(std::string_view species) {
    const std::size_t at = header_.selective ? 6 : 3;
    const bool listed = header_.named && !header_.from_title;
    if (listed || words_.size() <= at || atomic_number_of(symbol_in(words_[at])) == 0) {
      return species;
    }
    named_by_rows_ = true;
    return words_[at];
  }

  /// Returns the three numbers of the next row. Flags and other texts may follow them.
  Vec3d next_three(const char* what) {
    if (!at_row_) input_.next_row(rows_, header_.atoms, what);
    at_row_ = false;
    ++rows_;
    split_at_blanks(input_.line(), words_);
    if (words_.size() < 3) {
      input_.fail(std::to_string(words_.size()) +
                  " columns, but 3 are needed: write x, y and z of each atom");
    }
    return position_field(words_, 0, input_.place());
  }

  [[nodiscard]] Vec3d in_cell(const Vec3d& fractions) const {
    const auto& [a, b, c] = header_.edges;
    return fractions.x * a + fractions.y * b + fractions.z * c;
  }

  /// Reads the velocities, in angstrom per femtosecond, if the file has them and the request wants
  /// them. Velocities in fractions of the cell are per time step.
  void read_velocities(Particles& particles) {
    const bool wanted =
        std::ranges::any_of(velocity_names, [&](auto name) { return request_.wants(name); });
    if (!wanted || !go_to_velocities()) return;
    std::array<std::vector<double>, 3> columns;
    for (std::uint64_t i = 0; i < header_.atoms; ++i) {
      const Vec3d numbers = next_three("velocities");
      const Vec3d velocity = cartesian_ ? numbers : in_cell(numbers);
      columns[0].push_back(velocity.x);
      columns[1].push_back(velocity.y);
      columns[2].push_back(velocity.z);
    }
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const std::string name(velocity_names.at(i));
      if (request_.wants(name)) particles.numbers.push_back({name, std::move(columns.at(i))});
    }
  }

  /// Goes to the first row of the velocities, after lines on the velocity of the lattice. Returns
  /// false if other data or nothing follow the positions.
  bool go_to_velocities() {
    constexpr int lattice_lines = 7;  // state, three velocities, three vectors
    rows_ = 0;
    if (header_.atoms == 0 || !input_.next_line()) return false;
    const bool lattice = first_letter(input_.line()) == 'l';
    for (int i = 0; lattice && i <= lattice_lines; ++i) {
      if (!input_.next_line()) return false;
    }
    const char letter = first_letter(input_.line());
    const bool blank = trimmed(input_.line()).empty();
    cartesian_ = blank || is_cartesian(letter);
    at_row_ = (cartesian_ || letter == 'd') && input_.next_line() && is_velocity(input_.line());
    return at_row_;
  }

  /// Returns whether the line has three numbers that are not the size of a grid, as in CHGCAR.
  static bool is_velocity(std::string_view line) {
    const LineWords words = words_of(line);
    const auto is_size = [](std::string_view word) { return natural_in(word).value_or(0) > 0; };
    return words.size() == 3 && leading_numbers(line) == 3 && !std::ranges::all_of(words, is_size);
  }

  /// Goes to the first line of the next frame. Only XDATCAR has several frames.
  void go_to_frame() {
    rows_ = 0;
    at_frame_ = trajectory_ && input_.next_filled_line();
    at_row_ = at_frame_ && separated_by_blanks_;
  }

  void add_notes(Particles& particles) const {
    if (header_.atoms == 0) return;
    std::vector<ParticleNote>& notes = particles.facts.notes;
    if (particles.elements.empty()) {
      notes.push_back(
          {"unknown_elements", header_.atoms,
           in_number(header_.atoms, "atom of an unknown element", "atoms of unknown elements") +
               ", because the file names none"});
    } else if (header_.from_title && !named_by_rows_) {
      notes.push_back(guessed_elements_note(header_.atoms, "taken from the file's title"));
    }
  }

  PoscarHeader header_;
  bool at_frame_;                        // true: at the first line of the next frame
  bool at_row_ = false;                  // true: at a row that has not been read
  bool trajectory_ = false;              // true: XDATCAR
  bool separated_by_blanks_ = false;     // true: XDATCAR with blank lines between the frames
  bool cartesian_ = false;               // true: the current rows are not fractions of the cell
  bool named_by_rows_ = false;           // true: rows have symbols after the positions
  std::optional<double> configuration_;  // number of the frame in XDATCAR
  std::uint64_t rows_ = 0;               // rows read of the current block
  LineWords words_;                      // words of the current row
};

}  // namespace

/// Reads POSCAR, CONTCAR and XDATCAR, and the atoms of CHGCAR and LOCPOT, of VASP 4 (without names
/// of species) and later. Elements come from the line of names, from symbols after the positions,
/// or from the title. The lattice is the cell. The number of a frame in XDATCAR is its time.
/// Velocities are vx, vy, vz.
constinit const ParticleFormat poscar_format{.name = "POSCAR",
                                             .extensions = {".vasp", ".poscar", ".contcar"},
                                             .names = {"poscar", "contcar", "xdatcar"},
                                             .frames = true,
                                             .in_angstrom = true,
                                             .confidence = looks_like_poscar,
                                             .read = read_frame<PoscarFrames>};

}  // namespace parray::input
