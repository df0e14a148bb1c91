#include "cli/input/formats/foreign_files.h"

#include <algorithm>
#include <array>

#include "cli/input/formats/json_kind.h"
#include "cli/input/formats/recognisers.h"
#include "cli/input/particles/particle_text.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::string_view picture = "name a scene or a file of particles";
constexpr std::string_view archive = "unpack it, and name a file in it";
constexpr std::string_view packed =
    "unpack them first (what gzip, bzip2, xz and zstd have packed is read as it is)";
constexpr std::string_view mesh =
    "a mesh has no particles: save its vertices as PLY or CSV to see them as spheres";
constexpr std::string_view convert =
    "this format is not read: write XYZ, PDB or another that is with the program that made it";
constexpr std::string_view restart =
    "turn it into a data file or a dump (lmp -restart2data, -restart2dump)";
constexpr std::string_view binary_dump = "turn it into text by binary2txt of LAMMPS";
constexpr std::string_view hdf5 =
    "convert netCDF-4 with nccopy -k 64-bit-offset, anything else to XYZ or PDB with the program "
    "that made it";
constexpr std::string_view utf16 = "save the file as UTF-8";

struct Signature {
  std::string_view bytes;
  std::size_t at;
  std::string_view what;
  std::string_view remedy;
};

// Each from the public description of its format.
constexpr std::array<Signature, 39> signatures{{
    {"\x89PNG\r\n", 0, "a PNG picture", picture},
    {"\xff\xd8\xff", 0, "a JPEG picture", picture},
    {"GIF8", 0, "a GIF picture", picture},
    {"\x76\x2f\x31\x01", 0, "an EXR picture", picture},
    {"II*\0"sv, 0, "a TIFF picture", picture},
    {"MM\0*"sv, 0, "a TIFF picture", picture},
    {"%PDF-", 0, "a PDF document", picture},
    {"%!PS", 0, "a PostScript document", picture},
    {"\x7f"
     "ELF",
     0, "a program", picture},
    {"SQLite format 3", 0, "an SQLite database", picture},
    {"\x93NUMPY", 0, "a NumPy array", "write a CSV file with the columns x, y and z"},
    {"PK\x03\x04", 0, "a zip archive", archive},
    {"7z\xbc\xaf\x27\x1c", 0, "a 7z archive", archive},
    {"Rar!\x1a", 0, "a rar archive", archive},
    {"ustar", 257, "a tar archive", archive},
    {"\x1f\x8b", 0, "data packed twice", packed},
    {"\x28\xb5\x2f\xfd", 0, "data packed twice", packed},
    {"\xfd"
     "7zXZ",
     0, "data packed twice", packed},
    {"BZh", 0, "data packed twice", packed},
    {"\x04\x22\x4d\x18", 0, "data packed by lz4", packed},
    {"\x1f\x9d", 0, "data packed by compress", packed},
    {"glTF", 0, "a glTF mesh", mesh},
    {"OFF", 0, "an OFF mesh", mesh},
    {"# vtk DataFile", 0, "a VTK file", convert},
    {"MAP ", 208, "a density map", "name a file of atoms"},
    {"version https://git-lfs.github.com/spec", 0, "a Git LFS pointer",
     "fetch the file itself with git lfs pull"},
    {"LAMMPS (", 0, "a log of LAMMPS", "name the dump that the run has written"},
    {"!BIOSYM", 0, "a BIOSYM archive", convert},
    {"LammpS RestartT", 0, "a restart file of LAMMPS", restart},
    {"DUMPCUSTOM", 8, "a binary dump of LAMMPS", binary_dump},
    {"DUMPATOM", 8, "a binary dump of LAMMPS", binary_dump},
    {"---\ncreator: LAMMPS", 0, "a YAML dump of LAMMPS", "write it by dump custom, as text"},
    {"Number of particles = ", 0, "an AtomEye CFG file", convert},
    {"mmtfVersion", 4, "an MMTF file", convert},
    {"encoder", 2, "a BinaryCIF file", convert},
    {"GENERAL INFO", 40, "a TNG trajectory", convert},
    {"OVITO", 0, "a session of OVITO", "export the particles from it as extended XYZ"},
    {"\xff\xfe", 0, "UTF-16 text", utf16},
    {"\xfe\xff", 0, "UTF-16 text", utf16},
}};

/// Formats of particles that are told from others, but have no reader.
struct Unread {
  std::string_view what;
  std::string_view remedy;
  Recogniser looks;
};
constexpr std::array<Unread, 2> unread{{
    {"an HDF5 file", hdf5, looks_like_hdf5},
    {"a GSD file", convert, looks_like_gsd},
}};

struct Finding {
  std::string_view what;
  std::string_view remedy;
};

/// The lower-case words that begin the first lines.
std::vector<std::string> keywords_of(const FileStart& start) {
  std::vector<std::string> words;
  std::vector<std::string_view> fields;
  for (const std::string_view line : start.lines()) {
    split_at_blanks(line, fields);
    if (!fields.empty() && !fields[0].starts_with('#')) words.push_back(lower_case(fields[0]));
  }
  return words;
}

bool is_input_of_lammps(const std::vector<std::string>& keywords) {
  constexpr std::array<std::string_view, 12> commands{
      "units",      "atom_style", "pair_style", "pair_coeff", "read_data",   "read_restart",
      "create_box", "lattice",    "boundary",   "dimension",  "atom_modify", "neigh_modify"};
  return 3 <= std::ranges::count_if(commands, [&](std::string_view command) {
           return std::ranges::find(keywords, command) != keywords.end();
         });
}

/// Wavefront OBJ: vertices, three numbers each.
bool is_obj(const FileStart& start) {
  std::vector<std::string_view> fields;
  const auto is_vertex = [&](std::string_view line) {
    split_at_blanks(line, fields);
    return fields.size() >= 4 && fields[0] == "v" && number_in(fields[1]) && number_in(fields[2]);
  };
  return 3 <= std::ranges::count_if(start.lines(), is_vertex);
}

/// VASP: a title, a scale, three edges.
bool is_poscar(const FileStart& start) {
  std::vector<std::string_view> fields;
  for (std::size_t i = 1; i <= 4; ++i) {
    split_at_blanks(start.line(i), fields);
    if (fields.size() != (i == 1 ? 1 : 3)) return false;
    if (!std::ranges::all_of(fields, [](auto f) { return number_in(f).has_value(); })) return false;
  }
  return true;
}

std::vector<std::string_view> words_of_line(const FileStart& start, std::size_t line) {
  std::vector<std::string_view> words;
  split_at_blanks(start.line(line), words);
  return words;
}

/// A count and a title; rows of number, name, position, type, bonds.
bool is_tinker(const FileStart& start) {
  const auto head = words_of_line(start, 0);
  const auto atom = words_of_line(start, 1);
  return !head.empty() && natural_in(head[0]) && atom.size() >= 6 && atom[0] == "1" &&
         !number_in(atom[1]) && number_in(atom[2]) && number_in(atom[4]) && natural_in(atom[5]);
}

/// Titles that begin with a star, the last one empty, and a count.
bool is_charmm(const FileStart& start) {
  std::size_t line = 0;
  while (start.line(line).starts_with('*')) ++line;
  const auto count = words_of_line(start, line);
  return line > 0 && !count.empty() && count.size() <= 2 && natural_in(count[0]);
}

/// CONFIG and HISTORY: a title; two to five whole numbers, the keys of the trajectory and of the
/// box (0 to 7); a box or a time step.
bool is_dl_poly(const FileStart& start) {
  const auto keys = words_of_line(start, 1);
  const auto next = words_of_line(start, 2);
  const auto is_whole = [](std::string_view word) { return natural_in(word).has_value(); };
  if (keys.size() < 2 || keys.size() > 6 || !std::ranges::all_of(keys, is_whole)) return false;
  const bool small = natural_in(keys[0]) <= 2U && natural_in(keys[1]) <= 7U;
  const bool box = next.size() == 3 && std::ranges::all_of(next, [](std::string_view word) {
                     return number_in(word) && word.find('.') != std::string_view::npos;
                   });
  return small && (box || (!next.empty() && next[0] == "timestep"));
}

Finding text_without_signature(const FileStart& start) {
  const std::string_view first = trimmed(start.line(0));
  const std::string lower = lower_case(start.bytes().substr(0, 1024));
  const std::vector<std::string> keywords = keywords_of(start);
  if (lower.find("<html") != std::string::npos ||
      lower.find("<!doctype html") != std::string::npos) {
    return {"an HTML page", "was the download refused?"};
  }
  if (first.starts_with("<?xml") || first.starts_with("<VTKFile")) return {"XML text", convert};
  if (first.starts_with("solid") && start.bytes().find("facet") != std::string::npos) {
    return {"an STL mesh", mesh};
  }
  if (is_obj(start)) return {"an OBJ mesh", mesh};
  if (is_input_of_lammps(keywords)) {
    return {"an input script of LAMMPS", "run it, and name the dump that it writes"};
  }
  if (first == "TITLE" && std::ranges::count(keywords, "position") > 0) {
    return {"a GROMOS96 file", convert};
  }
  if (is_tinker(start)) return {"a Tinker file", convert};
  if (is_charmm(start)) return {"a CHARMM coordinate file", convert};
  if (is_dl_poly(start)) return {"a file of DL_POLY", convert};
  if (is_poscar(start)) return {"a POSCAR file of VASP", convert};
  return {};
}

Finding finding_of(const FileStart& start, const std::filesystem::path& name) {
  for (const Signature& known : signatures) {
    if (start.has(known.bytes, known.at)) return {known.what, known.remedy};
  }
  if (is_wide_json(start)) return {"UTF-16 text", utf16};
  for (const Unread& known : unread) {
    if (known.looks(start) >= Likeness::likely) return {known.what, known.remedy};
  }
  if (!start.is_text() && lower_case(name.extension().string()) == ".stl") {
    return {"an STL mesh", mesh};
  }
  return start.is_text() ? text_without_signature(start) : Finding{};
}

}  // namespace

std::string foreign_file(const FileStart& start, const std::filesystem::path& name) {
  const Finding finding = finding_of(start, name);
  if (finding.what.empty()) return {};
  return std::string(finding.what) + ": " + std::string(finding.remedy);
}

std::string first_words(const FileStart& start) {
  if (!start.is_text()) return "binary data of a kind that is not known";
  constexpr std::size_t most = 40;
  const std::string_view text = start.bytes();
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return "nothing but blanks";
  const std::string_view rest = text.substr(begin);
  return "text that begins with '" + printable(rest.substr(0, rest.find_first_of("\r\n")), most) +
         "'";
}

}  // namespace parray::input
