#include "cli/input/formats/unsupported_formats.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "cli/input/scene_file/scene_keys.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view picture = "name a scene or a particle file";
constexpr std::string_view packed =
    "unpack them first (ParRay itself unpacks one layer of gzip, bzip2, xz or zstd)";
constexpr std::string_view mesh =
    "a mesh has no particles: save its vertices as PLY or CSV to see them as spheres";
constexpr std::string_view convert =
    "ParRay does not read this format: write XYZ, PDB or another supported format with the program "
    "that made it";
constexpr std::string_view utf16 = "save the file as UTF-8";

/// What a file is instead of a scene or particles. `what` is empty for unknown files.
struct Unsupported {
  std::string_view what;
  std::string_view remedy;
};

struct Signature {
  std::string_view bytes;
  std::size_t at;
  Unsupported format;
};

// Signatures from the public descriptions of the formats.
constexpr std::array<Signature, 31> signatures{{
    {"\x89PNG\r\n", 0, {"a PNG picture", picture}},
    {"\xff\xd8\xff", 0, {"a JPEG picture", picture}},
    {"\x76\x2f\x31\x01", 0, {"an EXR picture", picture}},
    {"%PDF-", 0, {"a PDF document", picture}},
    {"\x7f\x45LF", 0, {"a program", picture}},
    {"SQLite format 3", 0, {"an SQLite database", picture}},
    {"\x93NUMPY", 0, {"a NumPy array", "write a CSV file with the columns x, y and z"}},
    {"PK\x03\x04", 0, {"a zip archive", "unpack it, and name a file in it"}},
    {"ustar", 257, {"a tar archive", "unpack it, and name a file in it"}},
    {"\x1f\x8b", 0, {"data packed twice", packed}},
    {"\x28\xb5\x2f\xfd", 0, {"data packed twice", packed}},
    {"\xfd\x37zXZ", 0, {"data packed twice", packed}},
    {"BZh", 0, {"data packed twice", packed}},
    {"\x04\x22\x4d\x18", 0, {"data packed by lz4", packed}},
    {"glTF", 0, {"a glTF mesh", mesh}},
    {"OFF", 0, {"an OFF mesh", mesh}},
    {"# vtk DataFile", 0, {"a VTK file", convert}},
    {"version https://git-lfs.github.com/spec",
     0,
     {"a Git LFS pointer", "fetch the file itself with git lfs pull"}},
    {"LAMMPS (", 0, {"a log of LAMMPS", "name the dump file of that run"}},
    {"!BIOSYM", 0, {"a BIOSYM archive", convert}},
    {"LammpS RestartT",
     0,
     {"a restart file of LAMMPS",
      "convert it to a data file or a dump (lmp -restart2data, -restart2dump)"}},
    {"DUMPCUSTOM", 8, {"a binary dump of LAMMPS", "convert it to text with binary2txt of LAMMPS"}},
    {"DUMPATOM", 8, {"a binary dump of LAMMPS", "convert it to text with binary2txt of LAMMPS"}},
    {"---\ncreator: LAMMPS", 0, {"a YAML dump of LAMMPS", "write text with dump custom"}},
    {"Number of particles = ", 0, {"an AtomEye CFG file", convert}},
    {"mmtfVersion", 4, {"an MMTF file", convert}},
    {"encoder", 2, {"a BinaryCIF file", convert}},
    {"GENERAL INFO", 40, {"a TNG trajectory", convert}},
    {"\xff\xfe", 0, {"UTF-16 text", utf16}},
    {"\xfe\xff", 0, {"UTF-16 text", utf16}},
    {"\x89HDF\r\n\x1a\n",
     0,
     {"an HDF5 file",
      "convert netCDF-4 with nccopy -k 64-bit-offset, other files to XYZ or PDB with the program "
      "that made it"}},
}};

constexpr std::string_view json_blanks = " \t\r\n";
constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";

/// A key at the top level of a JSON object. `inner` is the first key of its value, if the value is
/// an object.
struct TopLevelKey {
  std::string_view name;
  std::string_view inner;
  char value = 0;  ///< first character of the value
};

/// Collects the keys at the top level of a JSON object. The text may end anywhere.
class KeyScanner {
 public:
  explicit KeyScanner(std::string_view text) : text_(text) {}

  std::vector<TopLevelKey> scan() {
    for (char c = next(); c != 0; c = next()) {
      if (c == '"') {
        take_string();
      } else if (c == '{' || c == '[') {
        ++depth_;
      } else if ((c == '}' || c == ']') && --depth_ == 0) {
        break;
      }
    }
    return std::move(keys_);
  }

 private:
  char next() {
    const std::size_t found = text_.find_first_not_of(json_blanks, at_);
    at_ = found == std::string_view::npos ? text_.size() : found + 1;
    return found == std::string_view::npos ? '\0' : text_[found];
  }

  [[nodiscard]] char peek(std::size_t from) const {
    const std::size_t found = text_.find_first_not_of(json_blanks, from);
    return found == std::string_view::npos ? '\0' : text_[found];
  }

  /// Takes a string after its opening quote. A string with a colon after it is a key.
  void take_string() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    const std::string_view string = text_.substr(begin, std::min(at_, text_.size()) - begin);
    at_ = std::min(at_ + 1, text_.size());
    if (peek(at_) != ':') return;
    next();
    if (depth_ == 1) {
      keys_.push_back({string, {}, peek(at_)});
    } else if (depth_ == 2 && !keys_.empty() && keys_.back().inner.empty()) {
      keys_.back().inner = string;
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
  std::vector<TopLevelKey> keys_;
};

bool has_key(const std::vector<TopLevelKey>& keys, std::string_view name) {
  return std::ranges::find(keys, name, &TopLevelKey::name) != keys.end();
}

bool is_scene_key(const TopLevelKey& key) {
  return std::ranges::find(scene_keys, key.name) != scene_keys.end();
}

/// Returns whether the keys are those that DataFrame.to_json() of pandas writes for an object: by
/// column, by row, split, or with a schema.
bool is_table_of_pandas(const std::vector<TopLevelKey>& keys) {
  if (has_key(keys, "schema") && has_key(keys, "data")) return true;
  if (has_key(keys, "columns") && (has_key(keys, "data") || has_key(keys, "index"))) return true;
  const bool columns = has_key(keys, "x") && has_key(keys, "y");
  const bool rows = !keys.empty() && keys[0].name == "0" && keys[0].value == '{';
  return columns || rows;
}

/// Returns whether the text is a database of ASE, or atoms in the form of ase.io.jsonio.
bool is_atoms_of_ase(const FileStart& start, const std::vector<TopLevelKey>& keys) {
  const auto contains = [&](std::string_view text) {
    return start.bytes().find(text) != std::string_view::npos;
  };
  if (contains("\"__ase_objtype__\"")) return true;
  const bool numbered = !keys.empty() && keys[0].name == "1" && keys[0].value == '{';
  return contains("\"numbers\"") && contains("\"positions\"") &&
         (numbered || has_key(keys, "positions"));
}

std::string object_without_scene(const FileStart& start, std::string_view text) {
  const std::vector<TopLevelKey> keys = KeyScanner(text).scan();
  const bool may_be_scene = std::ranges::any_of(keys, is_scene_key);
  if (has_key(keys, "asset") && !has_key(keys, "spheres")) {
    return "a glTF mesh: a mesh has no particles: save its vertices as PLY or CSV to see them as "
           "spheres";
  }
  if (may_be_scene) return {};
  if (is_atoms_of_ase(start, keys)) {
    return "ASE atoms as JSON, not a scene: write extended XYZ with ASE (ase convert)";
  }
  if (is_table_of_pandas(keys)) {
    return "a table as JSON (from pandas), not a scene: write a CSV file with the columns "
           "x, y and z";
  }
  if (start.bytes().find("\"@module\"") != std::string_view::npos) {
    return "a pymatgen object as JSON, not a scene: write CIF or XYZ with pymatgen";
  }
  return {};
}

/// Returns whether a text with two or four bytes per character begins with a brace (UTF-16 or
/// UTF-32 without a byte order mark).
bool is_wide_json(const FileStart& start) {
  const std::size_t first = start.bytes().find_first_not_of(" \t\r\n\0"sv);
  if (first == std::string_view::npos || start.bytes()[first] != '{') return false;
  const std::string_view around = start.bytes().substr(0, first + 4);
  return std::ranges::count(around, '\0') >= 1;
}

bool is_html(const FileStart& start) {
  const std::string text = lower_case(start.bytes().substr(0, 1024));
  return text.find("<html") != std::string::npos ||
         text.find("<!doctype html") != std::string::npos;
}

bool is_xml(const FileStart& start) {
  const std::string_view first = trimmed(start.line(0));
  return first.starts_with("<?xml") || first.starts_with("<VTKFile");
}

bool is_stl(const FileStart& start) {
  return trimmed(start.line(0)).starts_with("solid") &&
         start.bytes().find("facet") != std::string::npos;
}

/// Recognises Wavefront OBJ: vertices with three numbers each.
bool is_obj(const FileStart& start) {
  const auto is_vertex = [](std::string_view line) {
    const auto words = words_of(line);
    return words.size() >= 4 && words[0] == "v" && is_number(words[1]) && is_number(words[2]);
  };
  return 3 <= std::ranges::count_if(start.lines(), is_vertex);
}

/// Returns whether a line begins with the word, in any letter case.
bool has_keyword(const FileStart& start, std::string_view keyword) {
  return std::ranges::any_of(start.lines(), [&](std::string_view line) {
    const auto words = words_of(line);
    return !words.empty() && lower_case(words[0]) == keyword;
  });
}

bool is_input_of_lammps(const FileStart& start) {
  constexpr std::array<std::string_view, 12> commands{
      "units",      "atom_style", "pair_style", "pair_coeff", "read_data",   "read_restart",
      "create_box", "lattice",    "boundary",   "dimension",  "atom_modify", "neigh_modify"};
  return 3 <= std::ranges::count_if(
                  commands, [&](std::string_view word) { return has_keyword(start, word); });
}

bool is_gromos96(const FileStart& start) {
  return trimmed(start.line(0)) == "TITLE" && has_keyword(start, "position");
}

/// Recognises Tinker: a count and a title; rows of number, name, position, type, bonds.
bool is_tinker(const FileStart& start) {
  const auto head = words_of(start.line(0));
  const auto atom = words_of(start.line(1));
  return !head.empty() && is_natural(head[0]) && atom.size() >= 6 && atom[0] == "1" &&
         !is_number(atom[1]) && is_number(atom[2]) && is_number(atom[4]) && is_natural(atom[5]);
}

/// Recognises CHARMM coordinates: titles that begin with a star, and a count.
bool is_charmm(const FileStart& start) {
  std::size_t line = 0;
  while (start.line(line).starts_with('*')) ++line;
  const auto count = words_of(start.line(line));
  return line > 0 && !count.empty() && count.size() <= 2 && is_natural(count[0]);
}

/// Recognises CONFIG and HISTORY: a title; two to five whole numbers, which are the keys of the
/// trajectory and of the box (0 to 7); a box or a time step.
bool is_dl_poly(const FileStart& start) {
  const auto keys = words_of(start.line(1));
  const auto next = words_of(start.line(2));
  if (keys.size() < 2 || keys.size() > 6 || !std::ranges::all_of(keys, is_natural)) return false;
  const bool small = natural_in(keys[0]) <= 2U && natural_in(keys[1]) <= 7U;
  const bool box = next.size() == 3 && std::ranges::all_of(next, [](std::string_view word) {
                     return is_number(word) && word.find('.') != std::string_view::npos;
                   });
  return small && (box || (!next.empty() && next[0] == "timestep"));
}

/// A text without a signature. The first matching shape counts.
struct Shape {
  bool (*fits)(const FileStart& start);
  Unsupported format;
};

constexpr std::array<Shape, 9> shapes{{
    {is_html, {"an HTML page", "check that the download succeeded"}},
    {is_xml, {"XML text", convert}},
    {is_stl, {"an STL mesh", mesh}},
    {is_obj, {"an OBJ mesh", mesh}},
    {is_input_of_lammps,
     {"an input script of LAMMPS", "run it and name the dump file that it writes"}},
    {is_gromos96, {"a GROMOS96 file", convert}},
    {is_tinker, {"a Tinker file", convert}},
    {is_charmm, {"a CHARMM coordinate file", convert}},
    {is_dl_poly, {"a file of DL_POLY", convert}},
}};

Unsupported format_of(const FileStart& start, const std::filesystem::path& name) {
  for (const Signature& known : signatures) {
    if (start.has(known.bytes, known.at)) return known.format;
  }
  if (is_wide_json(start)) return {"UTF-16 text", utf16};
  if (!start.is_text()) {
    const bool stl = lower_case(name.extension().string()) == ".stl";
    return stl ? Unsupported{"an STL mesh", mesh} : Unsupported{};
  }
  for (const Shape& known : shapes) {
    if (known.fits(start)) return known.format;
  }
  return {};
}

}  // namespace

std::string unsupported_format(const FileStart& start, const std::filesystem::path& name) {
  const Unsupported format = format_of(start, name);
  if (format.what.empty()) return {};
  return std::string(format.what) + ": " + std::string(format.remedy);
}

std::string first_words(const FileStart& start) {
  if (!start.is_text()) return "binary data of an unknown kind";
  constexpr std::size_t most = 40;
  const std::string_view text = start.bytes();
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return "only blanks";
  const std::string_view rest = text.substr(begin);
  return "text that begins with '" + printable(rest.substr(0, rest.find_first_of("\r\n")), most) +
         "'";
}

char first_character(PackedFile& file) {
  std::string_view text = file.start().bytes();
  if (text.starts_with(byte_order_mark)) text.remove_prefix(byte_order_mark.size());
  const std::size_t found = text.find_first_not_of(json_blanks);
  if (found != std::string_view::npos) return text[found];
  if (file.start().whole()) return 0;
  file.rewind();
  std::array<char, 65536> block{};
  char first = 0;
  for (bool head = true; first == 0; head = false) {
    std::string_view read(block.data(), file.read(block.data(), block.size()));
    if (read.empty()) break;
    if (head && read.starts_with(byte_order_mark)) read.remove_prefix(byte_order_mark.size());
    const std::size_t at = read.find_first_not_of(json_blanks);
    if (at != std::string_view::npos) first = read[at];
  }
  file.rewind();
  return first;
}

std::string json_without_scene(const FileStart& start, char first) {
  if (first != '{' && first != '[') return {};
  const std::string_view bytes = start.bytes();
  const std::size_t begin = bytes.find(first);
  if (begin == std::string_view::npos) return {};  // the first 64 KiB are blank
  const std::string_view text = bytes.substr(begin);
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {
    if (nul <= 3) return "UTF-16 text: save the file as UTF-8";
    return "JSON with a NUL byte (byte " + std::to_string(begin + nul + 1) +
           "): copy or write the file again";
  }
  if (first == '{') return object_without_scene(start, text);
  const std::size_t next = text.find_first_not_of(" \t\r\n[", 1);
  constexpr std::string_view begins_item = "{\"-0123456789]";
  if (next == std::string_view::npos || begins_item.find(text[next]) == std::string_view::npos) {
    return {};
  }
  return "a JSON list, not a scene: write a CSV file with the columns x, y and z, or a scene, "
         "which is an object ({ ... })";
}

}  // namespace parray::input
