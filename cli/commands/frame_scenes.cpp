#include "cli/commands/frame_scenes.h"

#include <filesystem>
#include <utility>

#include "cli/input/formats/format_table.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/particles/selected_particles.h"
#include "cli/input/view/auto_scene.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"

namespace parray::commands {
namespace {

/// Counts the frames of the trajectory of `source`, whose files are relative to `folder`.
std::uint64_t frames_in(const ParticleSource& source, const std::filesystem::path& folder) {
  PackedFile file(folder / source.file);
  ParticleRequest request = request_of(source, folder, usable_cpus());
  request.all = true;
  return read_particles(file, request).facts.frames.value_or(1);
}

}  // namespace

FrameScenes::FrameScenes(std::string file, const RenderOptions& options, NamedFiles named)
    : file_(std::move(file)), options_(options), named_(named) {
  PackedFile opened{std::filesystem::path(file_)};
  is_scene_ = particle_format_of(opened) == nullptr;
  if (!is_scene_ && options.particles().source().frame) {
    throw InputError("--frames and --frame exclude each other: leave one of them out");
  }
}

std::uint64_t FrameScenes::count() const {
  if (!is_scene_) {
    ParticleSource source = options_.particles().source();
    source.file = std::filesystem::path(file_).filename().string();
    return frames_in(source, std::filesystem::path(file_).parent_path());
  }
  PackedFile opened{std::filesystem::path(file_)};
  const SceneFile scene = read_scene_file(opened, usable_cpus());
  if (named_ == NamedFiles::beside) check_beside(scene, file_);
  const std::filesystem::path folder = std::filesystem::path(file_).parent_path();
  for (const ParticleSource& source : scene.particles) {
    if (!source.frame && may_hold_frames(folder / source.file)) return frames_in(source, folder);
  }
  throw InputError(printable(file_, 4096) +
                   ": the scene names no trajectory, so all frames would be equal: leave out the "
                   "frames");
}

SceneFile FrameScenes::at(std::uint64_t frame) {
  if (is_scene_) {
    FrameChange change;
    change.particles = frame;
    return load_scene(file_, options_, change, named_);
  }
  if (!shared_) shared_ = automatic_scene_of_frames(file_, options_, first_, named_);
  SceneFile scene = *shared_;
  scene.particles.front().frame = FrameChoice{frame, false};
  complete_scene(scene, file_);
  return scene;
}

}  // namespace parray::commands
