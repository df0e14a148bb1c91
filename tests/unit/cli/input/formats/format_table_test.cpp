#include "cli/input/formats/format_table.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "cli/input/scene_file/scene_file.h"
#include "common/scene/scene_bytes.h"
#include "tests/support/memory.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_particles.h"

namespace parray {
namespace {

using test::message_of;
using test::packed;
using test::ParticleFiles;
using std::string_literals::operator""s;

const std::vector<std::string> packings{"gzip", "bzip2", "xz", "zstd"};

const std::string scene_text =
    R"({"version": 1, "camera": {"look_from": [0, 0, 9], "look_at": [0, 0, 0], "vfov": 40},
        "materials": {"a": {"type": "diffuse", "albedo": [1, 1, 1]}},
        "spheres": [{"center": [0, 0, 0], "radius": 1, "material": "a"}]})";

/// "scene", the format's name, or what refuses the file, without its path.
std::string kind_of(const std::filesystem::path& path) {
  std::string kind;
  const std::string message = message_of<InputError>([&] {
    PackedFile file(path);
    const ParticleFormat* const format = particle_format_of(file);
    kind = format == nullptr ? "scene" : format->name;
  });
  return kind.empty() ? message.substr(path.string().size() + 2) : kind;
}

std::string format_for(const std::string& name) { return std::string(format_by_name(name)->name); }

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

/// The start of a zip archive with a file of this name.
std::string zip_with(const std::string& name) {
  return "PK\x03\x04" + std::string(26, '\0') + name;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Shipped scenes, and scenes of the report's own format.
std::vector<std::filesystem::path> scene_files() {
  const std::filesystem::path source = PARRAY_SOURCE_DIR;
  std::vector<std::filesystem::path> scenes{source / "tests/integration/seed-scene.json"};
  for (const char* folder : {"scenes", "scenes/regression"}) {
    for (const auto& entry : std::filesystem::directory_iterator(source / folder)) {
      if (entry.path().extension() == ".json") scenes.push_back(entry.path());
    }
  }
  return scenes;
}

/// As json.dumps() of Python writes it: one line, blanks behind commas and colons.
std::string as_python_writes(const auto& json) {
  std::string text;
  for (const char c : json.dump(0)) {
    if (c == '\n') {
      if (text.ends_with(',')) text += ' ';
    } else {
      text += c;
    }
  }
  return text;
}

/// The same JSON in every layout that programs write, by the layout's name.
std::map<std::string, std::string> layouts_of(const std::string& text) {
  const auto json = nlohmann::ordered_json::parse(text);
  const auto sorted = nlohmann::json::parse(text);
  return {{"as shipped", text},
          {"one line", as_python_writes(json)},
          {"compact", json.dump()},
          {"indented", json.dump(4)},
          {"indented by tabs", json.dump(1, '\t')},
          {"sorted keys", sorted.dump(2)},
          {"sorted keys on one line", as_python_writes(sorted)},
          {"a blank head", std::string(200'000, ' ') + as_python_writes(json)},
          {"a head of empty lines", std::string(70'000, '\n') + json.dump()},
          {"byte order mark", "\xEF\xBB\xBF" + as_python_writes(json)},
          {"byte order mark and blanks", "\xEF\xBB\xBF\r\n\t " + json.dump()}};
}

/// Names with every extension of a format, and with others.
std::vector<std::string> file_names() {
  std::vector<std::string> names{"dump.melt", "noname", "A.PDB", "a.json",
                                 "a.gz",      "a.zip",  "a.txt", "a.dat"};
  for (const ParticleFormat* const format : particle_formats()) {
    for (const std::string_view extension : format->extensions) {
      if (!extension.empty()) names.push_back("a" + std::string(extension));
    }
  }
  return names;
}

}  // namespace

TEST_CASE("a scene is a scene in every layout of JSON and under every name") {
  const ParticleFiles files;
  const auto scenes = scene_files();
  CHECK(scenes.size() > 15);
  for (const auto& path : scenes) {
    CAPTURE(path);
    const std::string identity = scene_identity(read_scene_file(path).scene);
    for (const auto& entry : layouts_of(text_of(path))) {
      const std::string& layout = entry.first;  // Clang 14 does not capture a structured binding
      CAPTURE(layout);
      const auto file = files.write("scene", entry.second);
      CHECK(kind_of(file) == "scene");
      CHECK(scene_identity(read_scene_file(file).scene) == identity);
    }
  }
  for (const auto& [layout, text] : layouts_of(text_of(scenes.front()))) {
    for (const std::string& name : file_names()) {
      CAPTURE(name);
      CHECK(kind_of(files.write(name, text)) == "scene");
    }
  }
}

TEST_CASE("other JSON files are refused with their kind") {
  const ParticleFiles files;
  const std::string pandas = "looks like a table as JSON (from pandas), not a scene: write";
  const std::string ase = "looks like ASE atoms as JSON, not a scene: write extended XYZ";
  const std::string list = "looks like a JSON list, not a scene: write a CSV file";
  const std::string utf16 = "looks like UTF-16 text: save the file as UTF-8";
  const std::vector<std::pair<std::string, std::string>> cases{
      {R"({"x": {"0": 1.0, "1": 2.0}, "y": {"0": 1.0, "1": 2.0}, "z": {"0": 1, "1": 2}})", pandas},
      {R"({"0": {"x": 1.0, "y": 2.0, "z": 3.0}, "1": {"x": 1.0, "y": 2.0, "z": 3.0}})", pandas},
      {R"({"columns":["x","y","z"],"index":[0],"data":[[1.0,2.0,3.0]]})", pandas},
      {R"({"schema": {"fields": [{"name": "x"}]}, "data": [{"x": 1, "y": 2, "z": 3}]})", pandas},
      {R"({"1": {"a": 1.0, "b": 2.0}, "2": {"a": 1.0, "b": 2.0}})", pandas},
      {R"({"pos_x": {"1": 1.0, "2": 2.0}, "pos_y": {"1": 1.0, "2": 2.0}})", pandas},
      {R"({"0": 1.0, "1": 2.0})", pandas},
      {R"({"1": {"ctime": 26.9, "mtime": 26.9, "numbers": {"__ndarray__": [[9]]}}})", ase},
      {R"({"numbers": [6], "cell": [], "positions": [[0, 0, 0]]})", ase},
      {"{\"x\": 1, \"y\": 2, \"z\": 3}\n{\"x\": 4, \"y\": 5, \"z\": 6}\n", pandas},
      {R"({"1": {"cell": [1], "numbers": [6], "positions": [[0, 0, 0]]}, "nextid": 2})", ase},
      {R"({"__ase_objtype__": "atoms", "x": 1, "y": 2, "z": 3})", ase},
      {R"({"@module": "pymatgen.core.structure", "@class": "Structure", "x": 1})",
       "looks like a pymatgen object as JSON"},
      {R"({"nodes": [], "asset": {"version": "2.0"}})", "looks like a glTF mesh"},
      {R"([{"x": 1, "y": 2, "z": 3}, {"x": 4, "y": 5, "z": 6}])", list},
      {"[[1, 2, 3],\n[4, 5, 6]]\n", list},
      {"[\n  {\"x\": 1}\n]\n", list},
      {"{\0\"\0s\0"s, utf16},
      {"\0{\0\"\0s"s, utf16},
      {" \0\n\0{\0\"\0s\0"s, utf16},
      {"\xff\xfe{\0\"\0"s, utf16},
      {R"({"version": 1, )" + "\0"s + scene_text.substr(1),
       "looks like JSON with a NUL byte (byte 16): copy or write the file again"}};
  for (const auto& [text, what] : cases) {
    for (const std::string& name : file_names()) {
      CAPTURE(name);
      const std::string kind = kind_of(files.write(name, text));
      CHECK_MESSAGE(kind.starts_with(what), kind);
    }
  }
}

TEST_CASE("keys below the top level do not make a scene something else") {
  const ParticleFiles files;
  std::string named = scene_text;
  for (std::size_t at = named.find("\"a\""); at != std::string::npos; at = named.find("\"a\"")) {
    named.replace(at, 3, "\"asset\"");
  }
  CHECK(kind_of(files.write("a", named)) == "scene");
  CHECK(read_scene_file(files.write("a", named)).scene.spheres.size() == 1);
}

TEST_CASE("a NUL byte far from the start of a scene is refused with its line") {
  const ParticleFiles files;
  std::string text = scene_text;
  text.insert(1, std::string(100'000, '\n'));
  text.insert(text.find("\"spheres\""), 1, '\0');
  const auto path = files.write("a", text);
  const std::string message = message_of<InputError>([&] { read_scene_file(path); });
  CHECK_MESSAGE(message.find("a:100003: ") != std::string::npos, message);
  CHECK_MESSAGE(message.find("NUL") != std::string::npos, message);
}

TEST_CASE("the content of a file decides its format, not its name") {
  const ParticleFiles files;
  for (const auto& [sample, bytes] : test::valid_particle_files()) {
    const std::string format = format_for(sample);
    for (const std::string& name : file_names()) {
      CAPTURE(name);
      // Columns of PQR may be those of PDB: the next test.
      const bool named_pdb = format_for("a.pdb") == (format_by_name(name) ? format_for(name) : "");
      if (format == "PQR" && named_pdb) continue;
      CHECK(kind_of(files.write(name, bytes)) == format);
    }
  }
  for (const char* name : {"scene", "a.xyz", "a.json", "a.JSON", "a.pdb", "a.csv"}) {
    CHECK(kind_of(files.write(name, scene_text)) == "scene");
    CHECK(kind_of(files.write(name, "\xEF\xBB\xBF \r\n" + scene_text)) == "scene");
  }
}

TEST_CASE("scenes and particles are read from every compression, also in several parts") {
  const ParticleFiles files;
  const std::string xyz = "2\n\nC 1 0 0\nO 2 0 0\n";
  for (const std::string& packing : packings) {
    CAPTURE(packing);
    for (const auto& [sample, bytes] : test::valid_particle_files()) {
      CHECK(kind_of(files.write("noname", packed(bytes, packing))) == format_for(sample));
    }
    const Particles particles = files.read("a", packed(xyz, packing));
    CHECK(particles.facts.packing == packing);
    CHECK(particles.positions == std::vector<Vec3d>{{1, 0, 0}, {2, 0, 0}});
    const std::string parts = packed("2\n\nC 1 0 0\n", packing) + packed("O 2 0 0\n", packing);
    CHECK(files.read("a", parts).positions == particles.positions);
    const SceneFile read = read_scene_file(files.write("s", packed(scene_text, packing)));
    CHECK(read.scene.spheres.size() == 1);
  }
  CHECK(files.read("a", xyz).facts.packing.empty());
}

TEST_CASE("the schema of scenes names all formats of particles") {
  std::ifstream file(PARRAY_SOURCE_DIR "/scenes/schema/scene.v1.schema.json");
  const auto schema = nlohmann::json::parse(file);
  const std::string text =
      schema.at("definitions").at("particles").at("properties").at("file").at("description");
  for (const ParticleFormat* format : particle_formats()) {
    if (format->holds == ParticleFormat::Holds::names) continue;
    CAPTURE(format->name);
    CHECK(text.find(" " + std::string(format->name)) != std::string::npos);
  }
}

TEST_CASE("formats of molecules are in angstrom, and the particles tell it") {
  const std::set<std::string_view> others{"PLY",    "LAMMPS dump", "LAMMPS data file", "GSD", "PSF",
                                          "PRMTOP", "CSV"};
  for (const ParticleFormat* format : particle_formats()) {
    CAPTURE(format->name);
    CHECK(format->in_angstrom == !others.contains(format->name));
  }
  const ParticleFiles files;
  CHECK(files.read("a.xyz", "1\n\nC 1 2 3\n").facts.length_unit == "angstrom");
  CHECK(files.read("a.csv", "x,y,z\n1,2,3\n").facts.length_unit.empty());
}

TEST_CASE("the name decides if the content fits several formats or is damaged") {
  const ParticleFiles files;
  const std::string amber =  // columns of PDB, in which PQR has a charge and a radius
      "ATOM      1  N   MET A   1      11.000   9.000  10.000  1.00 20.00\n";
  CHECK(kind_of(files.write("a", amber)) == "PDB");
  const std::string pqr = "ATOM      1  N   MET     1      11.000   9.000  10.000 -0.3000 1.8240\n";
  CHECK(kind_of(files.write("a", pqr)) == "PQR");
  CHECK(kind_of(files.write("a.pdb", pqr)) == "PDB");
  CHECK(kind_of(files.write("a.xyz", "3 atoms\n")) == "XYZ");
  CHECK(kind_of(files.write("a.csv", "a,b\n1,2\n")) == "CSV");
  CHECK(kind_of(files.write("a.pdb.zst", "nothing of PDB\n")) == "PDB");
  CHECK(kind_of(files.write("table", "a b c\n1 2 3\n")) == "CSV");
  CHECK(files.message("table", "a b c\n1 2 3\n") ==
        "table:1: the table has no column 'x': name the columns x, y and z");
}

TEST_CASE("unsupported files are refused with their kind") {
  const ParticleFiles files;
  const std::vector<std::pair<std::string, std::string>> cases{
      {"\x89PNG\r\n\x1a\n", "a PNG picture"},
      {"\xff\xd8\xff\xe0", "a JPEG picture"},
      {"\x76\x2f\x31\x01", "an EXR picture"},
      {"%PDF-1.7\n", "a PDF document"},
      {"\x7f"
       "ELF\2",
       "a program"},
      {"PK\x03\x04", "a zip archive"},
      {zip_with("x.npy"), "a NumPy archive (npz): 'python3 -m parray render FILE' reads it with"},
      {zip_with("[Content_Types].xml"), "an Excel workbook: 'python3 -m parray render FILE' reads"},
      {zip_with("mimetypeapplication/vnd.oasis.opendocument.spreadsheet"),
       "an OpenDocument sheet: save the sheet as CSV"},
      {"SQLite format 3",
       "an SQLite database: 'python3 -m parray render FILE' reads a database of"},
      {"LASF\0\0\0\0"s, "a LAS or LAZ point cloud: 'python3 -m parray render FILE' reads it with"},
      {"# .PCD v.7\nVERSION .7\nFIELDS x y z\nDATA ascii\n1 2 3\n",
       "a PCD point cloud: save it as PLY"},
      {"# .PCD v.7\nVERSION .7\nFIELDS x y z\nDATA binary\n\0\1\2"s, "a PCD point cloud"},
      {"VERSION 0.7\nFIELDS x y z\nPOINTS 1\nDATA ascii\n1 2 3\n", "a PCD point cloud"},
      {"SIMPLE  =                    T", "a FITS file: 'python3 -m parray render FILE' reads it"},
      {"PAR1\0"s, "a Parquet table: 'python3 -m parray render FILE' reads it with pyarrow"},
      {"ARROW1\0\0"s, "a Feather table"},
      {"FEA1\0\0"s, "a Feather table"},
      {"- of UlmASE-Trajectory  \0"s, "an ASE trajectory: 'python3 -m parray render FILE' reads"},
      {"# vtk DataFile Version 3.0\n", "a VTK file: 'python3 -m parray render FILE' reads it with"},
      {"<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\">\n", "a VTK file"},
      {"<?xml version=\"1.0\"?>\n<VOTABLE version=\"1.4\">\n", "a VOTable: 'python3 -m"},
      {"<?xml version=\"1.0\"?>\n<a/>\n", "XML text"},
      {"\x83\xa7version\xa5\x30.3.0\0"s, "a BinaryCIF file: download the entry as mmCIF"},
      {"\x83\xaa"
       "dataBlocks\x91\0"s,
       "a BinaryCIF file"},
      {"\xde\0\3\xa7"
       "encoder\0"s,
       "a BinaryCIF file"},
      {"# comment\nCRYSTAL\nPRIMVEC\n1 0 0\n0 1 0\n0 0 1\nPRIMCOORD\n1 1\n6 0 0 0\n",
       "an XSF file: 'python3 -m parray render FILE' reads it with ASE"},
      {"ANIMSTEPS 2\nATOMS 1\n6 0 0 0\nATOMS 2\n6 0 0 0\n", "an XSF file"},
      {"cube\nby Gaussian\n 1 0.0 0.0 0.0\n 2 0.1 0.0 0.0\n 2 0.0 0.1 0.0\n 2 0.0 0.0 0.1\n"
       " 6 6.0 0.0 0.0 0.0\n 0.1 0.2 0.3\n",
       "a cube of Gaussian: 'python3 -m parray render FILE' reads it with ASE"},
      {"# B\n\n2 atoms\n1 bonds\n\nCoords\n\n1 0 0 0\n2 1 0 0\n\nTypes\n\n1 1\n2 1\n",
       "a molecule template of LAMMPS: name a data file or a dump"},
      {std::string(257, 'x') + "ustar", "a tar archive"},
      {"\x89HDF\r\n\x1a\n", "an HDF5 file"},
      {"\xf6\xff\xff\xff\xff\xff\xff\xff"
       "DUMPCUSTOM\1",
       "a binary dump of LAMMPS"},
      {"LammpS RestartT\0"s, "a restart file of LAMMPS"},
      {"\xde\0\x27\xabmmtfVersion"s, "an MMTF file"},
      {"\x83\xa7"
       "encoder\xb6",
       "a BinaryCIF file"},
      {"\x3d\0\0\0"s + std::string(36, '\0') + "GENERAL INFO", "a TNG trajectory"},
      {"---\ncreator: LAMMPS\n", "a YAML dump of LAMMPS"},
      {"Number of particles = 4\n", "an AtomEye CFG file"},
      {"!BIOSYM archive 3\n", "a BIOSYM archive"},
      {"* CRAMBIN\n*\n 327\n 1 1 THR N 17.0 14.1 3.6\n", "a CHARMM coordinate file"},
      {"TITLE\nwater\nEND\nPOSITION\n", "a GROMOS96 file"},
      {"title\n 2 3 27\n 7.3 0.0 0.0\n 0.0 7.3 0.0\n 0.0 0.0 7.3\n", "a file of DL_POLY"},
      {"title\n 2 3 2000 0.5E-02\n 7.3 0.0 0.0\n 0.0 7.3 0.0\n 0.0 0.0 7.3\n", "a file of DL_POLY"},
      {"LAMMPS (23 Jun 2022)\n", "a log of LAMMPS"},
      {"# melt\nunits lj\natom_style atomic\nlattice fcc 1\npair_style lj/cut 2\n",
       "an input script of LAMMPS"},
      {"solid a\nfacet normal 0 0 1\n", "an STL mesh"},
      {"# obj\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "an OBJ mesh"},
      {"OFF\n3 1 0\n", "an OFF mesh"},
      {"{\"asset\": {\"version\": \"2.0\"}}", "a glTF mesh"},
      {"glTF\2\0\0\0"s, "a glTF mesh"},
      {"<!DOCTYPE html>\n<html>", "an HTML page: check that the download succeeded"},
      {"version https://git-lfs.github.com/spec/v1\n",
       "a Git LFS pointer: fetch the file itself with git lfs pull"},
      {"\xff\xfe{\0"s, "UTF-16 text: save the file as UTF-8"},
      {"\x93NUMPY", "a NumPy array"},
      {"\x04\x22\x4d\x18", "data packed by lz4"}};
  for (const auto& [bytes, what] : cases) {
    for (const char* name : {"noname", "a.json", "a.xyz", "a.pdb"}) {
      CAPTURE(name);
      const std::string kind = kind_of(files.write(name, bytes + "\n"));
      CHECK_MESSAGE(kind.starts_with("looks like " + what), kind);
      CHECK(kind.find(": ") != std::string::npos);  // and a remedy
    }
    CHECK(kind_of(files.write("noname", packed(bytes, "zstd"))).starts_with("looks like " + what));
  }
  CHECK(kind_of(files.write("a", packed(packed("1\n\nC 0 0 0\n"))))
            .starts_with("looks like data packed twice"));
}

TEST_CASE("names show formats whose texts have no mark") {
  const ParticleFiles files;
  const std::string text = "some words\nand more words\n";
  for (const auto& [name, what] :
       std::map<std::string, std::string>{{"a.res", "a SHELX file"},
                                          {"a.cell", "a cell of CASTEP"},
                                          {"a.castep.gz", "an output of CASTEP"}}) {
    CHECK(kind_of(files.write(name, text)) ==
          "looks like " + what + ": 'python3 -m parray render FILE' reads it with ASE");
  }
  CHECK(kind_of(files.write("a.gen",
                            "2 C\nC H\n1 1 1.0 2.0 3.0\n2 2 2.0 2.0 3.0\n"
                            "3 2 2.0 2.0 4.0\n4 2 2.0 2.0 5.0\n5 1 2.0 2.0 6.0\n"))
            .starts_with("looks like a GEN file of DFTB+"));
  const std::string xtl =
      "TITLE quartz\nDIMENSION 3\nCELL\n4.9 4.9 5.4 90 90 120\nSYMMETRY NUMBER 154\nATOMS\n"
      "NAME X Y Z\nSi 0.47 0 0\nEOF\n";
  for (const char* name : {"a.xtl", "a"}) {
    CHECK(kind_of(files.write(name, xtl)) ==
          "looks like an XTL file: 'python3 -m parray render FILE' reads it with ASE");
  }
  const std::string hdf5 = "\x89HDF\r\n\x1a\n and so on";
  CHECK(kind_of(files.write("a.hdf5", hdf5)).find("nccopy") == std::string::npos);
  CHECK(kind_of(files.write("a.hdf5", hdf5)).find("h5py") != std::string::npos);
  CHECK(kind_of(files.write("a.nc", hdf5)).starts_with("looks like a netCDF-4 file: convert it"));
}

TEST_CASE("unknown files are refused with their first words") {
  const ParticleFiles files;
  const std::string known = ": ParRay reads scene JSON, PLY, XYZ, LAMMPS dump,";
  CHECK(kind_of(files.write("README", "\n  Once upon\x1b a time\n"))
            .starts_with("the file is neither a scene nor a particle file, but binary data of an "
                         "unknown kind"));
  CHECK(kind_of(files.write("README", "\n  Once upon a time\nthere\n"))
            .starts_with("the file is neither a scene nor a particle file, but text that begins "
                         "with 'Once upon a "
                         "time'" +
                         known));
  CHECK(kind_of(files.write("a.json", "nan\n"))
            .starts_with("the file is neither a scene nor a particle file, but"));
  CHECK(kind_of(files.write("a", "\1\2\3"))
            .starts_with(
                "the file is neither a scene nor a particle file, but binary data of an unknown"));
  CHECK(kind_of(files.write("a", " \n")).find("only blanks") != std::string::npos);
  for (const std::string& packing : packings) {
    CHECK(kind_of(files.write("a", packed("", packing))) ==
          "the file is empty: check that the file is complete");
  }
  CHECK(kind_of(files.write("a", "")) == "the file is empty: check that the file is complete");
  CHECK(kind_of(files.path()) == "is a directory: name a file in it");
}

TEST_CASE("damaged and truncated data are refused in every compression") {
  const ParticleFiles files;
  std::string text = "2000\n\n";
  for (int i = 0; i < 2000; ++i) text += "C " + std::to_string(i * 0.37) + " 0 0\n";
  for (const std::string& packing : packings) {
    CAPTURE(packing);
    const std::string good = packed(text, packing);
    REQUIRE(files.message("a", good) == "no error");
    const std::string says = "a: damaged " + packing + " data (";
    for (const std::size_t bytes : {good.size() - 4, good.size() / 2, std::size_t{12}}) {
      CHECK(files.message("a", good.substr(0, bytes)).starts_with(says));
    }
    const std::string kept = packed(scene_text, packing);
    const auto cut = files.write("s", kept.substr(0, kept.size() - 4));
    CHECK(message_of<InputError>([&] { read_scene_file(cut); }).find("s: damaged " + packing) !=
          std::string::npos);
    std::string changed = good;
    for (std::size_t i = good.size() / 2; i < good.size() / 2 + 8; ++i) changed[i] ^= '\x55';
    const bool has_sums = packing != "zstd";  // there they are left to whoever packs
    if (has_sums) CHECK(files.message("a", changed).starts_with(says));
  }
}

TEST_CASE("data that expand a thousandfold are refused without allocating memory for them") {
  const ParticleFiles files;
  for (const std::string& packing : packings) {
    CAPTURE(packing);
    // 64 parts of 16 MiB each; what is refused is a line without an end, after 1 MiB.
    const std::string part = packed(std::string(std::size_t{1} << 24, '7'), packing);
    const auto path = files.write("a.xyz", repeated(part, 64));
    const std::uint64_t before = test::peak_address_space();
    CHECK(message_of<InputError>([&] {
            read_particles(path);
          }).find("a line has more than 1048576") != std::string::npos);
    CHECK(test::peak_address_space() - before < 400'000'000);
  }
}

TEST_CASE("a pipe can be read several times") {
  const ParticleFiles files;
  const std::filesystem::path path = files.path() / "pipe";
  REQUIRE(mkfifo(path.c_str(), 0600) == 0);
  std::jthread writer([&] { std::ofstream(path) << "1\n\nC 1 2 3\n"; });
  PackedFile file(path);
  writer.join();
  CHECK(particle_format_of(file)->name == "XYZ");
  CHECK(read_particles(file).positions == std::vector<Vec3d>{{1, 2, 3}});
  CHECK(read_particles(file).positions == std::vector<Vec3d>{{1, 2, 3}});
  CHECK(file.size() == 11);
}

TEST_CASE("bytes of a file are read, skipped and read again") {
  const ParticleFiles files;
  for (const std::string& bytes : {"0123456789"s, packed("0123456789")}) {
    PackedFile file(files.write("a", bytes));
    std::string four(4, '\0');
    CHECK(file.skip(3));
    CHECK(file.read(four.data(), 4) == 4);
    CHECK(four == "3456");
    CHECK(file.start().bytes() == "0123456789");
    CHECK(file.start().whole());
    CHECK(file.read(four.data(), 4) == 4);
    CHECK(four == "0123");
    CHECK_FALSE(file.skip(7));
    CHECK(file.read(four.data(), 4) == 0);
    file.rewind();
    CHECK(file.skip(10));
  }
}

}  // namespace parray
