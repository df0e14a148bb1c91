#include "common/input/particles/particles.h"

#include <array>
#include <optional>
#include <string_view>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/input/particles/particle_text.h"
#include "common/input/particles/readers.h"

namespace parray {
namespace {

struct Extension {
  std::string_view name;
  ParticleFormat format;
};

constexpr std::array<Extension, 10> extensions{{{".ply", ParticleFormat::ply},
                                                {".csv", ParticleFormat::csv},
                                                {".xyz", ParticleFormat::xyz},
                                                {".extxyz", ParticleFormat::xyz},
                                                {".lammpstrj", ParticleFormat::lammps},
                                                {".dump", ParticleFormat::lammps},
                                                {".pdb", ParticleFormat::pdb},
                                                {".ent", ParticleFormat::pdb},
                                                {".cif", ParticleFormat::mmcif},
                                                {".mmcif", ParticleFormat::mmcif}}};

std::optional<ParticleFormat> format_of(const std::filesystem::path& path) {
  std::string extension = lower_case(path.extension().string());
  if (extension == ".gz") extension = lower_case(path.stem().extension().string());
  for (const Extension& known : extensions) {
    if (known.name == extension) return known.format;
  }
  return {};
}

}  // namespace

ParticleFormat particle_format_of(const std::filesystem::path& path) {
  const std::optional<ParticleFormat> format = format_of(path);
  if (!format) {
    std::string known;
    for (const Extension& extension : extensions) known += " " + std::string(extension.name);
    FilePlace{path.string()}.fail("not the name of a particle file: use one of" + known +
                                  ", each also with .gz");
  }
  return *format;
}

bool is_particle_file(const std::filesystem::path& path) { return format_of(path).has_value(); }

bool may_hold_frames(const std::filesystem::path& path) {
  const std::optional<ParticleFormat> format = format_of(path);
  return format == ParticleFormat::xyz || format == ParticleFormat::lammps ||
         format == ParticleFormat::pdb;
}

Particles read_particles(const std::filesystem::path& path, std::uint64_t frame, int threads) {
  const ParticleFormat format = particle_format_of(path);
  if (frame > 0 && !may_hold_frames(path)) {
    FilePlace{path.string()}.fail("no frame " + std::to_string(frame) +
                                  ": only XYZ files, LAMMPS dumps and PDB files hold several");
  }
  GzipFile file(path);
  if (format == ParticleFormat::mmcif) return read_mmcif(file);
  ParticleInput input(file);
  switch (format) {
    case ParticleFormat::ply:
      return read_ply(input, threads);
    case ParticleFormat::csv:
      return read_csv(input);
    case ParticleFormat::xyz:
      return read_xyz(input, frame);
    case ParticleFormat::lammps:
      return read_lammps(input, frame);
    default:
      return read_pdb(input, frame);
  }
}

}  // namespace parray
