#include "cli/input/particles/particles.h"

#include "cli/input/formats/format_table.h"
#include "cli/input/particles/topology.h"

namespace parray::input {
namespace {

const ParticleFormat& format_of(PackedFile& file) {
  const ParticleFormat* const format = particle_format_of(file);
  if (format != nullptr) return *format;
  FilePlace{file.name()}.fail("a scene, where particles are needed: name a file of those");
}

Particles read(PackedFile& file, const ParticleFormat& format, const ParticleRequest& request) {
  const std::uint64_t frame = request.frame_number();
  if (frame > 0 && !format.frames) {
    FilePlace{file.name()}.fail("there is no frame " + std::to_string(frame) + ": a " +
                                std::string(format.name) + " file holds one, frame 0");
  }
  file.rewind();
  Particles particles = format.read(file, request);
  particles.facts.format = format.name;
  particles.facts.packing = file.packing();
  return particles;
}

}  // namespace

Particles read_particles(const std::filesystem::path& path, const ParticleRequest& request) {
  PackedFile file(path);
  return read_particles(file, request);
}

Particles read_particles(PackedFile& file, const ParticleRequest& request) {
  const ParticleFormat& format = format_of(file);
  if (format.holds == ParticleFormat::Holds::names) {
    FilePlace{file.name()}.fail("a " + std::string(format.name) +
                                " file has no positions: name a trajectory, and this file as its "
                                "topology");
  }
  if (request.topology.empty()) {
    Particles particles = read(file, format, request);
    if (format.holds == ParticleFormat::Holds::positions) {
      particles.facts.notes.push_back(
          {"nameless", particles.count(),
           "particles of which the file says only where they are: a topology names them"});
    }
    return particles;
  }
  ParticleRequest with_ids = request;
  with_ids.numbers.emplace("id");
  Particles particles = read(file, format, with_ids);
  take_topology(request.topology, file.name(), request, particles);
  std::erase_if(particles.numbers,
                [&](const NumberColumn& column) { return !request.wants(column.name); });
  return particles;
}

Particles read_names(const std::filesystem::path& path, const ParticleRequest& request) {
  PackedFile file(path);
  return read(file, format_of(file), request);
}

}  // namespace parray::input
