#include <array>

#include "cli/input/view/auto_scene.h"
#include "common/base/error.h"
#include "tests/fuzz/target.h"
#include "tests/support/particle_files.h"
#include "tests/support/rooms.h"
#include "tests/support/sample_particles.h"
#include "tests/support/sample_trajectories.h"

namespace parray::fuzz {
namespace {

struct Format {
  char letter;
  const char* file;
};
constexpr std::array<Format, 23> formats{
    {{'n', "f"},  // the bytes say all
     {'y', "f.ply"},    {'v', "f.csv"},   {'x', "f.xyz"},  {'l', "f.dump"},   {'p', "f.pdb"},
     {'m', "f.cif"},    {'q', "f.pdbqt"}, {'r', "f.pqr"},  {'g', "f.gro"},    {'s', "f.sdf"},
     {'2', "f.mol2"},   {'V', "f.vasp"},  {'G', "f.gsd"},  {'D', "f.dcd"},    {'T', "f.xtc"},
     {'R', "f.trr"},    {'C', "f.nc"},    {'A', "f.data"}, {'I', "f.inpcrd"}, {'S', "f.psf"},
     {'O', "f.prmtop"}, {'t', "f.txyz"}}};

/// Of any letter, so that none is in vain.
const char* file_for(char letter) {
  for (const Format& format : formats) {
    if (format.letter == letter) return format.file;
  }
  return formats[static_cast<unsigned char>(letter) % formats.size()].file;
}

void promise_auto_scene(const std::filesystem::path& path) {
  try {
    const AutoScene portrait = auto_scene(path, {}, auto_scene_settings());
    promise_usable(portrait.file.scene, portrait.file.settings);
  } catch (const InputError& error) {
    promise_one_line(error.what());
  }
}

/// Every column, and every frame. True when the file is taken: some formats hold names alone.
bool promise_names(const std::filesystem::path& path) {
  try {
    const Particles particles = read_names(path, {.all = true});
    for (const NumberColumn& column : particles.numbers) {
      promise(column.values.size() == particles.count(), "a number for each particle");
    }
    return true;
  } catch (const InputError& error) {
    promise_one_line(error.what());
    return false;
  }
}

bool run(std::string_view input) {
  static const test::ParticleFiles files;
  const char* const file = file_for(take_letter(input));
  const auto path = files.write(file, std::string(input));
  const bool named = promise_names(path);
  try {
    ParticleRequest request;
    request.all = true;
    const std::string broken = test::broken_promise(read_particles(path, request));
    promise(broken.empty(), "particles with " + broken);
  } catch (const InputError& error) {
    promise_one_line(error.what());
    promise(std::string_view(error.what()).starts_with(path.string()), "an error with its file");
    return named;
  }
  promise_auto_scene(path);
  return true;
}

char letter_for(const std::string& name) {
  const std::string extension = name.substr(name.find('.'));
  for (const Format& format : formats) {
    if (std::string_view(format.file).ends_with(extension)) return format.letter;
  }
  throw std::logic_error("a particle file of no format");
}

/// Each under its name and without one, as it is and in every packing.
std::vector<std::string> seeds() {
  std::vector<std::string> files;
  for (const auto& [name, bytes] : test::valid_particle_files()) {
    files.push_back(letter_for(name) + bytes);
    files.push_back('n' + bytes);
    for (const char* packing : {"gzip", "bzip2", "xz", "zstd"}) {
      files.push_back('n' + test::packed(bytes, packing));
    }
  }
  for (const auto& [name, bytes] : test::valid_simulation_files()) {
    files.push_back(letter_for(name) + bytes);
  }
  files.push_back('S' + test::psf());
  files.push_back('O' + test::prmtop());
  files.push_back('T' + test::wide_xtc());
  files.push_back("x2\n\nC 0 0 0\n8 1 2 3 4\n");
  files.push_back("v# c\nx y z r g b\n1 2 3 255 128 0\n\n4 5 6 0 0 0\n");
  files.push_back("v\"x\";y;z;type\n1;2;3;\"a;b\"\n");
  files.push_back("v# x [m] y [m] z [m] r_mm\n1 2 3 50\n4 5 6 50\n");
  files.push_back("vx y z v\nm m m m/s\n1,5 2 3 4\n");
  files.push_back("n1,5;2;3;7\n4;5;6;8\n");
  files.push_back("n2\n0 0 0 9 255 0 7\n1 1 1 8 0 255 6\n");
  files.push_back("n,0,1,2\n0,1.5,2,3\n");
  files.push_back("lITEM: NUMBER OF ATOMS\n1\nITEM: ATOMS x y z radius type\n1 2 3 0.5 Fe\n");
  files.push_back(
      "yply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\n"
      "property short y\nproperty int z\nend_header\n" +
      test::bytes_of(1.5F) + test::bytes_of(std::int16_t{-3}) + test::bytes_of(7));
  return files;
}

}  // namespace

const Target particles_target{"particles", run, seeds};

}  // namespace parray::fuzz
