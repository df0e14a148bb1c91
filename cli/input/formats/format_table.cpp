#include "cli/input/formats/format_table.h"

#include <algorithm>
#include <array>
#include <string>

#include "cli/input/formats/unsupported_formats.h"
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
