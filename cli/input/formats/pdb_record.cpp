#include "cli/input/formats/pdb_record.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/residues.h"
#include "common/base/ascii.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// Types of AutoDock that differ from the symbol of their element.
constexpr std::array<TypesOfElement, 5> autodock_types{{{" HD HS ", 1},
                                                        {" A CX G GA J Q CG ", 6},
                                                        {" NA NS NX ", 7},
                                                        {" OA OS OX W ", 8},
                                                        {" SA ", 16}}};

/// Returns the element of an atom type of AutoDock and Vina. Returns 0 for other texts and for the
/// pseudo-atoms G and CG that close rings. Source: AutoDock 4.2 User Guide, appendix "Parameters".
/// Source for W (water of hydrated docking) and the types of rings: the manual of Meeko
/// (meeko.readthedocs.io).
std::uint8_t element_of_autodock_type(std::string_view type) {
  // "CG0" closes a ring with the pseudo-atom "G0". In older versions, "G" alone is a carbon.
  const bool numbered = !type.empty() && ascii::is_digit(type.back());
  while (!type.empty() && ascii::is_digit(type.back())) type.remove_suffix(1);
  if (numbered && type == "G") return 0;
  return element_of_listed(autodock_types, type).value_or(atomic_number_of(type));
}

char record_column(std::string_view line, std::size_t at) {
  return line.size() < at ? ' ' : line[at - 1];
}

/// Parses "2+", "1-" or "+2". Returns not_known for other texts.
double formal_charge(std::string_view text) {
  if (text.size() != 2) return not_known;
  const bool sign_last = ascii::is_digit(text[0]);
  const char digit = sign_last ? text[0] : text[1];
  const char sign = sign_last ? text[1] : text[0];
  if (!ascii::is_digit(digit) || (sign != '+' && sign != '-')) return not_known;
  return (sign == '-' ? -1.0 : 1.0) * (digit - '0');
}

bool is_known_residue(std::string_view name) {
  return is_water(name) || is_amino_acid(name) || is_nucleotide(name) || ion_element(name) != 0;
}

std::optional<Vec3d> columns_position(std::string_view line) {
  constexpr std::size_t last = 54;
  if (line.size() < last || !record_field(line, 28, 30).empty()) return {};
  const auto x = number_in(record_field(line, 31, 38));
  const auto y = number_in(record_field(line, 39, 46));
  const auto z = number_in(record_field(line, 47, last));
  if (!x || !y || !z) return {};
  return Vec3d{*x, *y, *z};
}

/// Reads columns 17 to 22: alternative location, residue, chain.
void read_residue(std::string_view line, AtomRecord& record) {
  const char letter = record_column(line, 17);
  const std::string_view three = record_field(line, 18, 20);
  std::string_view name = three;
  std::string_view chain = record_field(line, 22, 22);
  if (record_column(line, 21) != ' ') {
    const std::string_view four = record_field(line, 18, 21);
    const bool part_of_chain =
        record_column(line, 20) == ' ' || (is_known_residue(three) && !is_known_residue(four));
    name = part_of_chain ? three : four;
    if (part_of_chain) chain = record_field(line, 21, 22);
  }
  record.alternative = letter;
  record.doubtful_alternative = false;
  const bool lipid = three == "OPC";  // a water model, and the end of POPC and DOPC
  if (letter != ' ' && name.size() == 3 && name == three && (lipid || !is_known_residue(three))) {
    const std::string_view from_17 = record_field(line, 17, 20);
    record.doubtful_alternative = !is_known_residue(from_17);
    if (!record.doubtful_alternative) {
      name = from_17;
      record.alternative = ' ';
    }
  }
  record.residue_name = name;
  record.chain = chain;
}

/// Returns whether columns 73 to 80 contain the entry name: "1ABC  12" or, revised, "1ABCF 12".
/// Entries before 1998 have it.
bool has_entry_name(std::string_view line) {
  const char sign = record_column(line, 79);
  return ascii::is_digit(record_column(line, 73)) && ascii::is_digit(record_column(line, 80)) &&
         sign != '+' && sign != '-';
}

/// Reads columns 23 to 27. A number of five digits replaces the insertion code.
void read_number(std::string_view line, AtomRecord& record) {
  const char last = record_column(line, 27);
  const bool five = ascii::is_digit(last) && ascii::is_digit(record_column(line, 26));
  record.residue_number = residue_number_in(record_field(line, 23, five ? 27 : 26)).value_or(0);
  record.insertion = five ? ' ' : last;
}

/// Returns whether columns 13 and 14 indicate a two-letter symbol. Names of four characters begin
/// in column 13, too. In these, only a small second letter indicates a symbol, except of hydrogen.
bool has_two_letters(std::string_view line, std::string_view name) {
  const char first = record_column(line, 13);
  const bool small = ascii::is_lower(record_column(line, 14)) && first != 'H';
  return ascii::is_letter(first) && (name.size() < 4 || small);
}

/// Returns the element of a name that is one letter in column 14, where symbols of one letter
/// stand. Returns nothing for other names, and for a bead, which is named like its residue.
std::optional<std::uint8_t> single_letter_element(std::string_view line, const AtomRecord& record) {
  const char letter = record_column(line, 14);
  if (record.name.size() != 1 || letter == ' ' || record.name == record.residue_name) return {};
  const std::uint8_t element = atomic_number_of(record.name);
  return element == 0 ? std::nullopt : std::optional(element);
}

void read_columns(std::string_view line, const Vec3d& position, AtomRecord& record) {
  record.position = position;
  record.name = record_field(line, 13, 16);
  record.two_letters = has_two_letters(line, record.name);
  read_residue(line, record);
  read_number(line, record);
  record.occupancy = number_or_nan(record_field(line, 55, 60));
  record.b_factor = number_or_nan(record_field(line, 61, 66));
}

/// Replaces tabs by blanks up to the next multiple of eight columns. Removes digits of a serial
/// number beyond column 11, because they shift the rest of the line.
std::string realigned(std::string_view line) {
  constexpr std::size_t tab = 8;
  constexpr std::size_t serial_end = 11;
  std::string text;
  for (const char c : line) {
    text.push_back(c == '\t' ? ' ' : c);
    while (c == '\t' && text.size() % tab != 0) text.push_back(' ');
  }
  std::size_t end = 6;
  while (end < text.size() && text[end] == ' ') ++end;
  while (end < text.size() && ascii::is_digit(text[end])) ++end;
  if (end > serial_end) text.erase(6, end - serial_end);
  return text;
}

/// The words of a line with blanks between fields.
class RecordWords {
 public:
  explicit RecordWords(std::string_view line) {
    split_at_blanks(line, words_);
    constexpr std::size_t longest = 6;  // "HETATM12345": no blank before the serial number
    if (!words_.empty() && words_[0].size() > longest) {
      words_[0].remove_prefix(longest);
    } else if (!words_.empty()) {
      words_.erase(words_.begin());
    }
  }

  /// Returns the place of x: the first word with a decimal point after the serial number and the
  /// name. Returns nothing unless x, y and z are numbers.
  [[nodiscard]] std::optional<std::size_t> find_position() const {
    std::size_t i = 2;
    while (i < words_.size() && !has_point(i)) ++i;
    return number(i) && number(i + 1) && number(i + 2) ? std::optional(i) : std::nullopt;
  }

  [[nodiscard]] bool has_point(std::size_t i) const {
    return i < words_.size() && words_[i].find('.') != std::string_view::npos;
  }
  [[nodiscard]] std::size_t size() const { return words_.size(); }
  [[nodiscard]] std::string_view operator[](std::size_t i) const { return words_[i]; }
  [[nodiscard]] std::optional<double> number(std::size_t i) const {
    return i < words_.size() ? number_in(words_[i]) : std::nullopt;
  }

 private:
  std::vector<std::string_view> words_;
};

/// Reads the number of a residue, possibly with the chain before it or the insertion code after it.
/// Returns false for other texts.
bool read_mixed_number(std::string_view text, AtomRecord& record) {
  if (text.size() > 1 && ascii::is_letter(text[0]) && !ascii::is_letter(text[1])) {
    record.chain = text.substr(0, 1);
    text.remove_prefix(1);
  }
  if (text.size() > 1 && ascii::is_letter(text.back())) {
    record.insertion = text.back();
    text.remove_suffix(1);
  }
  const auto number = residue_number_in(text);
  record.residue_number = number.value_or(0);
  return number.has_value() || text == "****";
}

/// Splits "ALA12" into residue name ALA and number 12.
void split_residue(std::string_view text, AtomRecord& record) {
  std::size_t digits = 0;
  while (digits < text.size() && ascii::is_digit(text[text.size() - 1 - digits])) ++digits;
  const bool together = digits > 0 && text.size() > digits + 1;
  record.residue_name = together ? text.substr(0, text.size() - digits) : text;
  record.residue_number =
      together ? residue_number_in(text.substr(text.size() - digits)).value_or(0) : 0;
}

/// Reads the fields before x: serial number, name, residue, chain, residue number. The last three
/// may be missing. Returns false for other fields.
bool read_identity(const RecordWords& words, std::size_t x, AtomRecord& record) {
  record.name = words[1];
  record.two_letters = false;
  record.alternative = record.insertion = ' ';
  record.doubtful_alternative = false;
  record.chain = {};
  record.residue_name = {};
  record.residue_number = 0;
  if (x == 3) {
    split_residue(words[2], record);
  } else if (x >= 4) {
    record.residue_name = words[2];
    if (x >= 5) record.chain = words[3];
    return read_mixed_number(words[x - 1], record);
  }
  return true;
}

bool read_words(const RecordWords& words, std::size_t x, AtomRecord& record) {
  if (x > 5 || !read_identity(words, x, record)) return false;
  record.position = {*words.number(x), *words.number(x + 1), *words.number(x + 2)};
  return true;
}

/// Returns whether x and y are in their columns. If they are, the fault of the line is not its
/// alignment.
bool has_columns(std::string_view line) {
  return record_field(line, 28, 30).empty() && number_in(record_field(line, 31, 38)) &&
         number_in(record_field(line, 39, 46));
}

/// Reads a line with blanks between fields. Returns false unless it has x, y, z, occupancy and
/// temperature factor, because otherwise the meaning of the fields is unclear.
bool read_loose(std::string_view line, AtomRecord& record) {
  const RecordWords words(line);
  const auto x = words.find_position();
  if (!x || !words.has_point(*x + 3) || !words.has_point(*x + 4)) return false;
  if (!read_words(words, *x, record)) return false;
  record.occupancy = words.number(*x + 3).value_or(not_known);
  record.b_factor = words.number(*x + 4).value_or(not_known);
  record.charge = not_known;
  record.element.reset();
  const std::uint8_t element = atomic_number_of(words[words.size() - 1]);
  if (element != 0) record.element = element;
  return true;
}

[[noreturn]] void fail_position(std::string_view line, const FilePlace& place) {
  if (line.size() < 54) {
    place.fail_incomplete("the record ends before column 54, the last of its coordinates");
  }
  for (const auto& [name, first] : {std::pair{"x", 31U}, {"y", 39U}, {"z", 47U}}) {
    number_field(record_field(line, first, first + 7), std::string(name), place);
  }
  place.fail(
      "text precedes the coordinates in columns 31 to 54: check that the columns are not shifted");
}

/// Reads the part of a record that PDB and PDBQT share. Returns the line with its columns aligned.
/// Returns nothing if blanks separate the fields.
std::optional<std::string_view> read_shared(std::string_view line, const FilePlace& place,
                                            AtomRecord& record) {
  if (line.find('\0') != std::string_view::npos) {
    place.fail_damaged("the record contains a zero byte");
  }
  const bool tabs = line.find('\t') != std::string_view::npos;
  auto position = tabs ? std::nullopt : columns_position(line);
  if (!position) {
    record.aligned = realigned(line);
    position = columns_position(record.aligned);
    const bool loose = !position && !has_columns(line) && read_loose(line, record);
    if (!position && !loose) fail_position(line, place);
    if (!position) return {};
    line = record.aligned;
  }
  read_columns(line, *position, record);
  return line;
}

}  // namespace

bool is_record(std::string_view line, std::string_view name) {
  return std::ranges::equal(line.substr(0, name.size()), name, {},
                            [](char c) { return ascii::upper(c); });
}

bool is_atom_record(std::string_view line) {
  if (line.size() < 7) return false;
  if (is_record(line, "HETATM")) return true;
  return is_record(line, "ATOM") && (ascii::is_blank(line[4]) || ascii::is_digit(line[4]));
}

void read_pdb_record(std::string_view line, const FilePlace& place, AtomRecord& record) {
  const auto fixed = read_shared(line, place, record);
  if (!fixed) return;
  record.element = single_letter_element(*fixed, record);
  record.charge = not_known;
  if (has_entry_name(*fixed)) return;
  const std::uint8_t element = atomic_number_of(record_field(*fixed, 77, 78));
  if (element != 0) record.element = element;
  record.charge = formal_charge(record_field(*fixed, 79, 80));
  if (record.chain.empty()) record.chain = record_field(*fixed, 73, 76);
}

void read_pdbqt_record(std::string_view line, const FilePlace& place, AtomRecord& record) {
  const auto fixed = read_shared(line, place, record);
  if (fixed) {
    record.charge = number_or_nan(record_field(*fixed, 67, 76));
    record.type = record_field(*fixed, 78, 80);
  } else {
    const RecordWords words(line);
    record.type = words[words.size() - 1];
    record.charge = number_or_nan(words[words.size() - 2]);
  }
  record.element = element_of_autodock_type(record.type);
}

void read_pqr_record(std::string_view line, const FilePlace& place, AtomRecord& record) {
  constexpr std::size_t coordinates_end = 54;
  record.element.reset();
  const RecordWords words(line);
  const auto x = words.find_position();
  std::optional<double> charge;
  std::optional<double> radius;
  if (x && read_words(words, *x, record)) {
    charge = words.number(*x + 3);
    radius = words.number(*x + 4);
  }
  if (!charge || !radius) {  // fields without blanks between them
    const std::string_view fixed = read_shared(line, place, record).value_or(line);
    const std::vector<std::string_view> rest =
        words_of(fixed.size() > coordinates_end ? fixed.substr(coordinates_end) : "");
    if (rest.size() < 2) {
      place.fail("fewer than two numbers follow the coordinates: add charge and radius");
    }
    charge = number_field(rest[0], "the charge", place);
    radius = number_field(rest[1], "the radius", place);
  }
  record.occupancy = not_known;
  record.charge = *charge;
  record.radius = *radius;
}

}  // namespace parray::input
