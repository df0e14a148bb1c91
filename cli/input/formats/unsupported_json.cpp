#include "cli/input/formats/unsupported_json.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "cli/input/scene_file/scene_fields.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

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

}  // namespace

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
