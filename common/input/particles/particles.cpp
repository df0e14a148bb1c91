#include "common/input/particles/particles.h"

#include "common/input/formats/format_table.h"

namespace parray {
namespace {

const ParticleFormat& known_format(const std::filesystem::path& path) {
  if (const ParticleFormat* format = format_by_name(path)) return *format;
  std::string known;
  for (const ParticleFormat& format : particle_formats()) {
    for (const std::string_view extension : format.extensions)
      known += " " + std::string(extension);
  }
  FilePlace{path.string()}.fail("not the name of a particle file: use one of" + known +
                                ", each also with .gz");
}

}  // namespace

bool is_particle_file(const std::filesystem::path& path) { return format_by_name(path) != nullptr; }

bool may_hold_frames(const std::filesystem::path& path) {
  const ParticleFormat* const format = format_by_name(path);
  return format != nullptr && format->frames;
}

Particles read_particles(const std::filesystem::path& path, const ParticleRequest& request) {
  const ParticleFormat& format = known_format(path);
  const std::uint64_t frame = request.frame_number();
  if (frame > 0 && !format.frames) {
    FilePlace{path.string()}.fail("no frame " + std::to_string(frame) +
                                  ": only XYZ files, LAMMPS dumps and PDB files hold several");
  }
  PackedFile file(path);
  Particles particles = format.read(file, request);
  particles.facts.format = format.name;
  particles.facts.frame = frame;
  return particles;
}

}  // namespace parray
