#include "common/input/particles/particles.h"

#include "common/input/formats/format_table.h"

namespace parray {

Particles read_particles(const std::filesystem::path& path, const ParticleRequest& request) {
  PackedFile file(path);
  return read_particles(file, request);
}

Particles read_particles(PackedFile& file, const ParticleRequest& request) {
  const ParticleFormat* const format = particle_format_of(file);
  const FilePlace place{file.name()};
  if (format == nullptr) place.fail("a scene, where particles are needed: name a file of those");
  const std::uint64_t frame = request.frame_number();
  if (frame > 0 && !format->frames) {
    place.fail("no frame " + std::to_string(frame) + ": a " + std::string(format->name) +
               " file holds one alone");
  }
  file.rewind();
  Particles particles = format->read(file, request);
  particles.facts.format = format->name;
  particles.facts.packing = file.packing();
  particles.facts.frame = frame;
  return particles;
}

}  // namespace parray
