#include "cli/input/formats/format_table.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "cli/input/formats/unsupported_formats.h"
#include "cli/input/scene_file/scene_file.h"
#include "common/base/ascii.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// CSV is last, because every table could be CSV.
constexpr std::array<const ParticleFormat*, 22> formats{
    &ply_format,    &xyz_format,    &lammps_dump_format, &lammps_data_format, &dcd_format,
    &xtc_format,    &trr_format,    &netcdf_format,      &gsd_format,         &inpcrd_format,
    &psf_format,    &prmtop_format, &pdb_format,         &pdbqt_format,       &pqr_format,
    &poscar_format, &gro_format,    &sdf_format,         &mol2_format,        &tinker_format,
    &cif_format,    &csv_format};

struct Guess {
  const ParticleFormat* format = nullptr;
  Confidence confidence = Confidence::none;
};

/// Returns the format with the highest confidence, or the first of several equal ones. Prefers
/// `named`, if that is possible, to formats that are not certain.
Guess best_guess(const FileStart& start, const ParticleFormat* named) {
  Guess best;
  for (const ParticleFormat* const format : formats) {
    const Confidence confidence = format->confidence(start);
    if (confidence > best.confidence) best = {format, confidence};
  }
  const bool fits = named != nullptr && named->confidence(start) != Confidence::none;
  return fits && best.confidence != Confidence::certain ? Guess{named, Confidence::likely} : best;
}

bool is_comment_line(std::string_view line) {
  const std::string_view text = trimmed(line);
  return text.empty() || text.starts_with('#');
}

/// Returns whether the start of a text ends before its data: in its first lines, which may be long;
/// in comments, which may follow a title; or in the header of a format.
bool is_only_header(const FileStart& start) {
  constexpr std::size_t first_lines = 4;
  if (start.whole() || !start.is_text()) return false;
  const auto& lines = start.lines();
  if (lines.size() < first_lines || std::all_of(lines.begin() + 1, lines.end(), is_comment_line)) {
    return true;
  }
  return std::ranges::any_of(formats, [&](const ParticleFormat* format) {
    return format->only_header != nullptr && format->only_header(start);
  });
}

/// Returns enough of the file to recognise its format, if possible.
const FileStart& start_with_data(PackedFile& file) {
  constexpr std::size_t most = std::size_t{1} << 24;
  std::size_t bytes = FileStart::usual_bytes;
  while (bytes < most && is_only_header(file.start(bytes))) bytes *= 16;
  return file.start(bytes);
}

/// Fails if `other_json` names another kind of JSON file.
void refuse_json(const FilePlace& place, const std::string& other_json) {
  if (!other_json.empty()) place.fail("looks like " + other_json);
}

/// Returns whether `name` begins with a word of the format: "poscar", "contcar.gz", "poscar_2".
bool has_name(const ParticleFormat& format, std::string_view name) {
  return std::ranges::any_of(format.names, [&](std::string_view word) {
    const bool begins = !word.empty() && name.starts_with(word);
    return begins && (name.size() == word.size() || !ascii::is_lower(name[word.size()]));
  });
}

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
  /// Returns the next character that is not blank, without taking it. Returns 0 at the end.
  char peek() {
    at_ = std::min(text_.find_first_not_of(json_blanks, at_), text_.size());
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  char next() {
    const char c = peek();
    at_ = std::min(at_ + 1, text_.size());
    return c;
  }

  /// Takes a string after its opening quote. A string with a colon after it is a key.
  void take_string() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    const std::string_view string = text_.substr(begin, std::min(at_, text_.size()) - begin);
    at_ = std::min(at_ + 1, text_.size());
    if (peek() != ':') return;
    next();
    if (depth_ == 1) {
      keys_.push_back({string, {}, peek()});
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

/// Returns whether the keys are those that DataFrame.to_json() of pandas writes for an object: by
/// column, by row (both with the numbers of the rows), split, or with a schema.
bool is_table_of_pandas(const std::vector<TopLevelKey>& keys) {
  if (has_key(keys, "schema") && has_key(keys, "data")) return true;
  if (has_key(keys, "columns") && (has_key(keys, "data") || has_key(keys, "index"))) return true;
  if (has_key(keys, "x") && has_key(keys, "y")) return true;
  return !keys.empty() && (is_natural(keys[0].name) || is_natural(keys[0].inner));
}

/// Returns whether the text is a database of ASE, or atoms in the form of ase.io.jsonio.
bool is_atoms_of_ase(const FileStart& start, const std::vector<TopLevelKey>& keys) {
  const auto contains = [&](std::string_view text) {
    return start.bytes().find(text) != std::string_view::npos;
  };
  if (contains("\"__ase_objtype__\"")) return true;
  const bool numbered = !keys.empty() && is_natural(keys[0].name) && keys[0].value == '{';
  if (numbered) {
    return contains("\"numbers\"") && (contains("\"positions\"") || contains("\"mtime\""));
  }
  return has_key(keys, "numbers") && has_key(keys, "positions");
}

std::string object_without_scene(const FileStart& start, std::string_view text) {
  const std::vector<TopLevelKey> keys = KeyScanner(text).scan();
  const bool may_be_scene = std::ranges::any_of(
      keys, [](const TopLevelKey& key) { return place_in(scene_keys, key.name).has_value(); });
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

/// Returns the first character of the file after blanks and a byte order mark. Returns 0 if there
/// is none. Reads beyond the start of the file if that contains only blanks.
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

/// Returns what a file that begins with a brace or a bracket seems to be instead of a scene, and
/// the remedy: "a table as JSON (from pandas), not a scene: ...". Returns "" if the file may be a
/// scene. `first` is the file's first_character(). Reads only the first bytes.
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

/// Returns a description of a file for messages: "text that begins with 'ABC'", "only blanks" or
/// "binary data of an unknown kind".
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

}  // namespace

std::span<const ParticleFormat* const> particle_formats() { return formats; }

const ParticleFormat* format_by_name(const std::filesystem::path& path) {
  const std::string extension = lower_case(unpacked_name(path).extension().string());
  const auto has_it = [&](const ParticleFormat* format) {
    return std::ranges::find(format->extensions, extension) != format->extensions.end();
  };
  const auto* const found = std::ranges::find_if(formats, has_it);
  if (!extension.empty() && found != formats.end()) return *found;
  const std::string name = lower_case(path.filename().string());
  const auto* const named = std::ranges::find_if(
      formats, [&](const ParticleFormat* format) { return has_name(*format, name); });
  return named == formats.end() ? nullptr : *named;
}

const ParticleFormat* particle_format_of(PackedFile& file) {
  const FilePlace place{file.name()};
  const char first = first_character(file);
  const std::string other_json = json_without_scene(file.start(), first);
  if (first == '{' && other_json.empty()) return nullptr;
  const FileStart& start = start_with_data(file);
  const ParticleFormat* const named = format_by_name(file.path());
  const Guess guess = best_guess(start, named);
  const bool is_table = guess.format == &csv_format;  // a JSON list resembles a table
  if (first == '{' || is_table) refuse_json(place, other_json);
  if (guess.confidence >= Confidence::likely) return guess.format;
  refuse_json(place, other_json);
  if (start.bytes().empty()) place.fail_incomplete("the file is empty");
  const std::string unsupported = unsupported_format(start, unpacked_name(file.path()));
  if (!unsupported.empty()) place.fail("looks like " + unsupported);
  if (named != nullptr) return named;
  if (guess.format != nullptr) return guess.format;
  std::string known = "scene JSON";
  for (const ParticleFormat* const format : formats) known.append(", ").append(format->name);
  place.fail("the file is neither a scene nor a particle file, but " + first_words(start) +
             ": ParRay reads " + known);
}

}  // namespace parray::input
