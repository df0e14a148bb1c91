#include "cli/input/formats/unsupported_formats.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
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
constexpr std::string_view unpack_it = "unpack it, and name a file in it";
constexpr std::string_view to_csv =
    "save the sheet as CSV, with a header line that names x, y and z";
constexpr std::string_view to_ply =
    "save it as PLY (pcl_pcd2ply, CloudCompare or Open3D), which keeps colours";

constexpr std::string_view python = "'python3 -m parray render FILE' reads ";

/// What a file is instead of a scene or particles. `what` is empty for unknown files.
struct Unsupported {
  std::string_view what;
  std::string_view remedy;
  std::string_view end{};  ///< the end of the remedy, if that is `python`
};

struct Signature {
  Unsupported format;
  std::string_view bytes;
  std::size_t at = 0;
};

// Signatures from the public descriptions of the formats.
constexpr auto signatures = std::to_array<Signature>({
    {{"a PNG picture", picture}, "\x89PNG\r\n"},
    {{"a JPEG picture", picture}, "\xff\xd8\xff"},
    {{"an EXR picture", picture}, "\x76\x2f\x31\x01"},
    {{"a PDF document", picture}, "%PDF-"},
    {{"a program", picture}, "\x7f\x45LF"},
    {{"an SQLite database", python, "a database of ASE (.db) with ASE"}, "SQLite format 3"},
    {{"a NumPy array", python, "it with NumPy"}, "\x93NUMPY"},
    {{"a tar archive", unpack_it}, "ustar", 257},
    {{"data packed twice", packed}, "\x1f\x8b"},
    {{"data packed twice", packed}, "\x28\xb5\x2f\xfd"},
    {{"data packed twice", packed}, "\xfd\x37zXZ"},
    {{"data packed twice", packed}, "BZh"},
    {{"data packed by lz4", packed}, "\x04\x22\x4d\x18"},
    {{"a glTF mesh", mesh}, "glTF"},
    {{"an OFF mesh", mesh}, "OFF"},
    {{"a LAS or LAZ point cloud", python, "it with laspy"}, "LASF"},
    {{"a PCD point cloud", to_ply}, "# .PCD"},
    {{"a FITS file", python, "it with astropy"}, "SIMPLE  ="},
    {{"a Parquet table", python, "it with pyarrow"}, "PAR1"},
    {{"a Feather table", python, "it with pyarrow"}, "ARROW1"},
    {{"a Feather table", python, "it with pyarrow"}, "FEA1"},
    {{"an ASE trajectory", python, "it with ASE"}, "- of Ulm"},
    {{"a VTK file", python, "it with OVITO"}, "# vtk DataFile"},
    {{"a Git LFS pointer", "fetch the file itself with git lfs pull"},
     "version https://git-lfs.github.com/spec"},
    {{"a log of LAMMPS", "name the dump file of that run"}, "LAMMPS ("},
    {{"a BIOSYM archive", convert}, "!BIOSYM"},
    {{"a restart file of LAMMPS",
      "convert it to a data file or a dump (lmp -restart2data, -restart2dump)"},
     "LammpS RestartT"},
    {{"a binary dump of LAMMPS", "convert it to text with binary2txt of LAMMPS"}, "DUMPCUSTOM", 8},
    {{"a binary dump of LAMMPS", "convert it to text with binary2txt of LAMMPS"}, "DUMPATOM", 8},
    {{"a YAML dump of LAMMPS", "write text with dump custom"}, "---\ncreator: LAMMPS"},
    {{"an AtomEye CFG file", python, "it with ASE"}, "Number of particles = "},
    {{"an MMTF file", python, "it with MDAnalysis"}, "mmtfVersion", 4},
    {{"a TNG trajectory", convert}, "GENERAL INFO", 40},
    {{"UTF-16 text", utf16}, "\xff\xfe"},
    {{"UTF-16 text", utf16}, "\xfe\xff"},
});

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

/// Returns whether the first bytes contain `text`.
bool begins_with_part(const FileStart& start, std::string_view text) {
  constexpr std::size_t most = 4096;
  return start.bytes().substr(0, most).find(text) != std::string_view::npos;
}

bool is_vtk_xml(const FileStart& start) { return begins_with_part(start, "<VTKFile"); }

bool is_votable(const FileStart& start) { return begins_with_part(start, "<VOTABLE"); }

bool is_xml(const FileStart& start) { return trimmed(start.line(0)).starts_with("<?xml"); }

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

/// Returns how many of the words begin a line, in any letter case.
std::ptrdiff_t count_keywords(const FileStart& start,
                              std::initializer_list<std::string_view> keywords) {
  return std::ranges::count_if(keywords, [&](std::string_view keyword) {
    return std::ranges::any_of(start.lines(), [&](std::string_view line) {
      const auto words = words_of(line);
      return !words.empty() && lower_case(words[0]) == keyword;
    });
  });
}

bool is_input_of_lammps(const FileStart& start) {
  return count_keywords(start, {"units", "atom_style", "pair_style", "pair_coeff", "read_data",
                                "read_restart", "create_box", "lattice", "boundary", "dimension",
                                "atom_modify", "neigh_modify"}) >= 3;
}

bool is_gromos96(const FileStart& start) {
  return trimmed(start.line(0)) == "TITLE" && count_keywords(start, {"position"}) == 1;
}

/// Recognises CHARMM coordinates: titles that begin with a star, and a count.
bool is_charmm(const FileStart& start) {
  std::size_t line = 0;
  while (start.line(line).starts_with('*')) ++line;
  const auto count = words_of(start.line(line));
  return line > 0 && !count.empty() && count.size() <= 2 && is_natural(count[0]);
}

/// Recognises CONFIG and HISTORY: a title; two to six numbers, of which the first two are the keys
/// of the trajectory and of the box (0 to 7); a box or a time step.
bool is_dl_poly(const FileStart& start) {
  const auto keys = words_of(start.line(1));
  const auto next = words_of(start.line(2));
  if (keys.size() < 2 || keys.size() > 6 || !std::ranges::all_of(keys, is_number)) return false;
  const bool small = natural_in(keys[0]).value_or(9) <= 2U && natural_in(keys[1]).value_or(9) <= 7U;
  const bool box = next.size() == 3 && std::ranges::all_of(next, [](std::string_view word) {
                     return is_number(word) && word.find('.') != std::string_view::npos;
                   });
  return small && (box || (!next.empty() && next[0] == "timestep"));
}

/// Recognises molecule templates of LAMMPS (manual, "molecule"): a number of atoms, and a section
/// of coordinates, but no box.
bool is_molecule_template(const FileStart& start) {
  const auto counts_atoms = [](std::string_view line) {
    const auto words = words_of(line);
    return words.size() >= 2 && is_natural(words[0]) && words[1] == "atoms";
  };
  return count_keywords(start, {"coords"}) == 1 && std::ranges::any_of(start.lines(), counts_atoms);
}

/// Recognises XTL: a title, a cell, and atoms with fractional coordinates.
bool is_xtl(const FileStart& start) {
  return count_keywords(start, {"title", "cell", "atoms"}) == 3;
}

/// Recognises XSF and AXSF (xcrysden.org/doc/XSF.html), in which comments begin with #.
bool is_xsf(const FileStart& start) {
  for (const std::string_view line : start.lines()) {
    const auto words = words_of(line);
    if (words.empty() || words[0].starts_with('#')) continue;
    constexpr std::array<std::string_view, 8> keywords{
        "CRYSTAL", "SLAB", "POLYMER", "MOLECULE", "ATOMS", "ANIMSTEPS", "PRIMVEC", "DIM-GROUP"};
    return place_in(keywords, words[0]).has_value();
  }
  return false;
}

/// Recognises cubes of Gaussian: two titles; a whole number and three numbers on each of four
/// lines: atoms and origin, then three axes; an atom with five numbers.
bool is_cube(const FileStart& start) {
  for (std::size_t i = 2; i <= 5; ++i) {
    const auto words = words_of(start.line(i));
    const std::size_t most = i == 2 ? 5 : 4;  // a number of values may follow the origin
    if (words.size() < 4 || words.size() > most || !std::ranges::all_of(words, is_number)) {
      return false;
    }
    const std::string_view count = words[0].starts_with('-') ? words[0].substr(1) : words[0];
    if (!is_natural(count)) return false;
  }
  const auto atom = words_of(start.line(6));
  return atom.size() == 5 && std::ranges::all_of(atom, is_number);
}

/// Recognises PCD without its first comment.
bool is_pcd(const FileStart& start) {
  return count_keywords(start, {"fields", "points", "data", "version"}) == 4;
}

/// A text without a signature. The first matching shape counts.
struct Shape {
  bool (*fits)(const FileStart& start);
  Unsupported format;
};

constexpr auto shapes = std::to_array<Shape>({
    {is_html, {"an HTML page", "check that the download succeeded"}},
    {is_vtk_xml, {"a VTK file", python, "it with OVITO"}},
    {is_votable, {"a VOTable", python, "it with astropy"}},
    {is_xml, {"XML text", convert}},
    {is_stl, {"an STL mesh", mesh}},
    {is_obj, {"an OBJ mesh", mesh}},
    {is_input_of_lammps,
     {"an input script of LAMMPS", "run it and name the dump file that it writes"}},
    {is_molecule_template,
     {"a molecule template of LAMMPS",
      "name a data file or a dump of a simulation with these molecules"}},
    {is_xtl, {"an XTL file", python, "it with ASE"}},
    {is_xsf, {"an XSF file", python, "it with ASE"}},
    {is_pcd, {"a PCD point cloud", to_ply}},
    {is_gromos96, {"a GROMOS96 file", convert}},
    {is_charmm, {"a CHARMM coordinate file", convert}},
    {is_dl_poly, {"a file of DL_POLY", convert}},
    {is_cube, {"a cube of Gaussian", python, "it with ASE"}},
});

/// A format that only the file's name shows.
struct NamedFormat {
  std::string_view extension;
  Unsupported format;
};

constexpr auto named_formats = std::to_array<NamedFormat>({
    {".res", {"a SHELX file", python, "it with ASE"}},
    {".cell", {"a cell of CASTEP", python, "it with ASE"}},
    {".castep", {"an output of CASTEP", python, "it with ASE"}},
    {".cssr", {"a CSSR file", python, "it with ASE"}},
    {".gen", {"a GEN file of DFTB+", python, "it with ASE"}},
    {".imd", {"an IMD file", python, "it with OVITO"}},
});

/// Recognises MessagePack with a key of BinaryCIF at the top level: a map of three, in either form.
bool is_binary_cif(const FileStart& start) {
  constexpr std::array<std::string_view, 3> keys{"encoder", "version", "dataBlocks"};
  const std::size_t key = start.has("\x83") ? 2 : 4;  // after the length of the key
  const bool map = start.has("\x83") || start.has("\xde\0\3"sv);
  return map && std::ranges::any_of(keys, [&](auto text) { return start.has(text, key); });
}

/// Returns what a zip archive contains, by the names in it.
Unsupported format_of_zip(const FileStart& start, std::string_view extension) {
  constexpr std::size_t name_at = 30;  // name of the first file
  const std::string_view bytes = start.bytes();
  const std::string_view first = bytes.substr(std::min(name_at, bytes.size()), 60);
  if (first.find(".npy") < first.size()) return {"a NumPy archive (npz)", python, "it with NumPy"};
  if (first.find("opendocument.spreadsheet") < first.size()) {
    return {"an OpenDocument sheet", to_csv};
  }
  const bool office = first.starts_with("[Content_Types].xml") || first.starts_with("_rels/") ||
                      first.starts_with("docProps/") || first.starts_with("xl/");
  if (office && extension != ".docx") return {"an Excel workbook", python, "it with pandas"};
  return {"a zip archive", unpack_it};
}

/// Names HDF5. The file's name shows netCDF-4, which has the same signature.
Unsupported format_of_hdf5(std::string_view extension) {
  constexpr std::array<std::string_view, 3> of_netcdf{".nc", ".nc4", ".ncdf"};
  if (place_in(of_netcdf, extension)) {
    return {"a netCDF-4 file", "convert it to netCDF-3 with nccopy -k 64-bit-offset"};
  }
  return {"an HDF5 file", python, "snapshots (Gadget, Arepo, SWIFT, H5MD) with h5py"};
}

Unsupported format_of(const FileStart& start, const std::filesystem::path& name) {
  const std::string extension = lower_case(name.extension().string());
  if (is_binary_cif(start)) {
    return {"a BinaryCIF file", "download the entry as mmCIF (.cif) instead"};
  }
  if (start.has("PK\x03\x04")) return format_of_zip(start, extension);
  if (start.has("\x89HDF\r\n\x1a\n")) return format_of_hdf5(extension);
  for (const Signature& known : signatures) {
    if (start.has(known.bytes, known.at)) return known.format;
  }
  if (is_wide_json(start)) return {"UTF-16 text", utf16};
  if (!start.is_text() && extension == ".stl") return {"an STL mesh", mesh};
  if (!start.is_text()) return {};
  for (const Shape& known : shapes) {
    if (known.fits(start)) return known.format;
  }
  const auto* const named = std::ranges::find(named_formats, extension, &NamedFormat::extension);
  return named == named_formats.end() ? Unsupported{} : named->format;
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
}  // namespace

std::string unsupported_format(const FileStart& start, const std::filesystem::path& name) {
  const Unsupported format = format_of(start, name);
  if (format.what.empty()) return {};
  return std::string(format.what).append(": ").append(format.remedy).append(format.end);
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
