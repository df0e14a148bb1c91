#include "cli/commands/frame_scenes.h"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <span>

#include "cli/input/formats/format_table.h"
#include "cli/input/particles/packed_file.h"
#include "cli/input/view/auto_scene.h"
#include "cli/input/view/silhouette.h"
#include "common/base/cpu_count.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/process/stop_signal.h"
#include "common/scene/limits.h"

namespace parray::commands {
namespace {

/// Counts the frames of the trajectory of `source`, whose files are relative to `folder`.
std::uint64_t frames_in(const ParticleSource& source, const std::filesystem::path& folder) {
  PackedFile file(folder / source.file);
  ParticleRequest request = request_of(source, folder, usable_cpus());
  request.all = true;
  return read_particles(file, request).facts.frames.value_or(1);
}

SceneFile read_scene(const std::string& file, NamedFiles named) {
  PackedFile opened{std::filesystem::path(file)};
  return read_scene(opened, named);
}

[[noreturn]] void fail_without_trajectory(const std::string& file) {
  throw InputError(printable(file, 4096) +
                   ": the scene names no trajectory, or chooses a frame itself, so all frames "
                   "would be equal: leave out --frames");
}

std::filesystem::path folder_of(const std::string& file) {
  return std::filesystem::path(file).parent_path();
}

/// Returns the first source of a scene whose file may hold frames among which it does not choose.
const ParticleSource* trajectory_of(const SceneFile& scene, const std::filesystem::path& folder) {
  const auto found = std::ranges::find_if(scene.particles, [&](const ParticleSource& source) {
    return !source.frame && may_hold_frames(folder / source.file);
  });
  return found == scene.particles.end() ? nullptr : &*found;
}

/// Returns the least and the largest depth of spheres, at every angle if they turn about the axis.
NumberBounds depths_of(const std::vector<Sphere>& spheres, const Camera& camera,
                       const TurnAxis& axis, bool turns) {
  const int angles = turns ? 60 : 1;
  const Vec3d forward = normalize(camera.look_at - camera.look_from);
  NumberBounds depths;
  for (const Sphere& sphere : spheres) {
    for (int i = 0; i < angles; ++i) {
      const Vec3d center = turned(sphere.center, axis, 360.0 * i / angles);
      const double depth = dot(center - camera.look_from, forward);
      depths.add(depth - sphere.radius);
      depths.add(depth);
    }
  }
  return depths;
}

/// Lets the frames without neighbours be read, although these determine the length of arrows: all
/// frames have no arrows until FixedLooks::apply_to() gives all the same.
void postpone_arrows(ParticleSource& source) {
  if (!source.arrows.empty() && !source.arrow_scale) source.arrow_measure = ArrowMeasure{};
}

/// Returns the result of `work`. Adds the number of the frame to its errors, except to those of
/// labels, which all frames have.
auto of_frame(std::uint32_t frame, const auto& work) {
  try {
    return work();
  } catch (const LabelError&) {
    throw;
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + " (this is frame " + std::to_string(frame) +
                     "; --frames chooses others)");
  }
}

constexpr std::uint32_t usual_count = 100;

std::vector<std::uint32_t> numbers_in(const FrameRange& range) {
  std::vector<std::uint32_t> numbers(range.count());
  for (std::uint32_t i = 0; i < range.count(); ++i) numbers[i] = range.number(i);
  return numbers;
}

/// Returns the text of a range that ends at a frame, with the first frame and step of `range`.
std::string range_up_to(std::uint64_t last, const FrameRange& range) {
  const std::string step = range.step == 1 ? "" : ":" + std::to_string(range.step);
  return std::to_string(std::min<std::uint64_t>(range.first, last)) + ":" + std::to_string(last) +
         step;
}

void check(const FilmCourse& course) {
  if (course.turntable != 0 && !course.camera_path.empty()) {
    throw InputError(
        "--turntable and --camera-path exclude each other: leave --turntable out, and turn the "
        "cameras of the path");
  }
  if (course.count && course.frames) {
    throw InputError("--count and --frames exclude each other: leave one of them out");
  }
  if (has_frame_number(course.scene) && !(course.frames && course.frames->range)) {
    throw InputError("--frames: say which of the numbered files are frames, such as 0:100");
  }
}

}  // namespace

FrameScenes::FrameScenes(std::string file, const RenderOptions& options, NamedFiles named,
                         std::uint32_t first)
    : file_(std::move(file)),
      options_(options),
      named_(named),
      first_(first),
      numbered_(has_frame_number(file_)) {
  const auto has_scene = [&] {
    PackedFile opened{std::filesystem::path(file_of(first))};
    return particle_format_of(opened) == nullptr;
  };
  is_scene_ = numbered_ ? of_frame(first, has_scene) : has_scene();
}

std::string FrameScenes::file_of(std::uint32_t frame) const {
  return with_frame_number(file_, frame);
}

ParticleSource FrameScenes::given_source() const {
  ParticleSource source = options_.particles().source();
  if (!source.topology.empty() && named_ == NamedFiles::anywhere) {
    source.topology = std::filesystem::absolute(source.topology).string();  // else beside the file
  }
  return source;
}

bool FrameScenes::is_still() const {
  if (numbered_) return false;
  if (!is_scene_) return given_source().frame || !may_hold_frames(file_);
  return trajectory_of(read_scene(file_, named_), folder_of(file_)) == nullptr;
}

std::uint64_t FrameScenes::count() const {
  if (!is_scene_) {
    ParticleSource source = given_source();
    source.file = std::filesystem::path(file_).filename().string();
    return frames_in(source, folder_of(file_));
  }
  const SceneFile scene = read_scene(file_, named_);
  if (const ParticleSource* const source = trajectory_of(scene, folder_of(file_))) {
    return frames_in(*source, folder_of(file_));
  }
  fail_without_trajectory(file_);
}

std::vector<std::string> files_named_in(const std::string& scene_file, NamedFiles named) {
  std::vector<std::string> files;
  const std::filesystem::path folder = folder_of(scene_file);
  for (const ParticleSource& source : read_scene(scene_file, named).particles) {
    files.push_back((folder / source.file).string());
    if (!source.topology.empty()) files.push_back((folder / source.topology).string());
  }
  return files;
}

std::vector<std::string> FrameScenes::files(const std::vector<std::uint32_t>& frames) const {
  std::vector<std::string> files;
  const auto add = [&](const std::string& file) {
    files.push_back(file);
    if (is_scene_) std::ranges::move(files_named_in(file, named_), std::back_inserter(files));
  };
  if (!numbered_) add(file_);
  for (const std::uint32_t frame : numbered_ ? frames : std::vector<std::uint32_t>()) {
    of_frame(frame, [&] { add(file_of(frame)); });
  }
  if (!is_scene_ && !given_source().topology.empty()) files.push_back(given_source().topology);
  return files;
}

void FrameScenes::fix(const std::vector<std::uint32_t>& frames, bool turns, bool still) {
  still_ = still;
  if (!still_ && !numbered_ && !is_scene_ && given_source().frame) {
    throw InputError(
        "--frames and --frame exclude each other without --camera-path: leave one of them out");
  }
  const std::vector<std::uint32_t> shown = still_ ? std::vector{first_} : frames;
  is_scene_ ? fix_scene(shown) : fix_particles(shown, turns);
}

void FrameScenes::note_read(std::size_t all) {
  check_interrupted();
  ++read_;
  if (on_read_) on_read_(read_, all);
}

void FrameScenes::fix_scene(const std::vector<std::uint32_t>& frames) {
  if (numbered_) return;  // each has its own camera and colours
  PackedFile opened{std::filesystem::path(file_)};
  shared_ = scene_without_particles(opened, options_, named_);
  axis_ = axis_of(shared_->scene.camera);
  if (frames.size() == 1) return;
  std::ranges::for_each(shared_->particles, postpone_arrows);
  FixedLooks looks;
  for (const std::uint32_t frame : frames) {
    looks.add(read(frame).particle_files);
    note_read(frames.size());
  }
  looks.apply_to(shared_->particles);
}

void FrameScenes::fix_particles(const std::vector<std::uint32_t>& frames, bool turns) {
  Viewing viewing = viewing_of(options_);
  ParticleSource source = given_source();
  if (!still_ && !numbered_) source.frame = FrameChoice{frames.front(), false};
  if (frames.size() > 1) postpone_arrows(source);
  const auto make = [&] {
    auto [scene, axis] =
        automatic_scene_of_frames(file_of(frames.front()), options_, source, viewing, named_);
    shared_ = std::move(scene);
    axis_ = axis;
  };
  if (frames.size() > 1) {
    of_frame(frames.front(), make);
  } else {
    make();
  }
  if (frames.size() == 1 && !turns) return;
  viewing.turns = turns;
  FixedLooks looks;
  include_all(frames, viewing, [&](const SceneFile& scene) {
    looks.add(scene.particle_files);
    note_read(frames.size());
  });
  if (looks.apply_to(shared_->particles) && frames.size() > 1) {
    include_all(frames, viewing, [&](const SceneFile&) { note_read(2 * frames.size()); });
  }
  source = shared_->particles.front();
  if (!still_ && !numbered_) source.frame = FrameChoice{frames.front(), false};
  make();
  shared_->postprocessing.depths =
      depths_of(viewing.other_spheres, shared_->scene.camera, axis_, turns);
}

void FrameScenes::include_all(const std::vector<std::uint32_t>& frames, Viewing& viewing,
                              const std::function<void(const SceneFile&)>& on_scene) {
  const bool cell = viewing.whole_cell || shared_->particles.front().cell.crystal.value_or(false);
  Silhouette silhouette;
  viewing.other_points.clear();
  for (const std::uint32_t frame : frames) {
    const SceneFile scene = read(frame);
    silhouette.add(std::span(scene.scene.spheres).subspan(scene.scenery), usable_cpus());
    silhouette.add(scene.scene.capsules, usable_cpus());
    for (const Vec3d& corner : cell&& scene.cell ? corners_of(*scene.cell) : std::vector<Vec3d>{}) {
      viewing.other_points.push_back(corner);
    }
    on_scene(scene);
  }
  viewing.other_spheres = silhouette.spheres();
}

SceneFile FrameScenes::read(std::uint32_t frame) {
  return of_frame(frame, [&] { return with_particles(frame); });
}

SceneFile FrameScenes::with_particles(std::uint32_t frame) {
  SceneFile scene = *shared_;
  if (numbered_) {
    open_.clear();
    scene.particles.front().file = std::filesystem::path(file_of(frame)).filename().string();
  } else if (!still_ && is_scene_) {
    if (!choose_frame(scene, frame, file_)) fail_without_trajectory(file_);
  } else if (!still_) {
    scene.particles.front().frame = FrameChoice{frame, false};
  }
  complete_scene(scene, file_, &open_);
  return scene;
}

SceneFile FrameScenes::at(std::uint32_t frame) {
  if (!shared_ && !(numbered_ && is_scene_)) fix({frame});
  if (!shared_) return load_scene(file_of(frame), options_, {}, named_);
  if (!still_) return with_particles(frame);
  if (!only_) only_ = with_particles(frame);
  return *only_;
}

void turn(SceneFile& scene, const TurnAxis& axis, double degrees) {
  scene.scene.camera = turned(scene.scene.camera, axis, degrees);
  for (Sphere& sphere : std::span(scene.scene.spheres).first(scene.scenery)) {
    sphere.center = turned(sphere.center, axis, degrees);
  }
}

FilmFrames::FilmFrames(const FilmCourse& course, const RenderOptions& options,
                       const OnRead& on_read)
    : course_(course) {
  check(course);
  if (course.frames && course.camera_path.empty() && options.particles().source().frame) {
    throw InputError(
        "--frames and --frame exclude each other without --camera-path: leave one of them out");
  }
  const std::uint32_t first =
      course.frames && course.frames->range ? course.frames->range->first : 0;
  scenes_ = std::make_unique<FrameScenes>(course.scene, options, NamedFiles::anywhere, first);
  if (!course.camera_path.empty()) path_.emplace(course.camera_path);
  numbers_ = chosen();
  for (const std::uint32_t frame : numbers_) {
    if (path_) (void)path_->at(frame);
  }
  scenes_->report_reading(on_read);
  scenes_->fix(numbers_, course.turntable != 0, still_);
  scenes_->report_reading({});
}

std::vector<std::uint32_t> FilmFrames::chosen() {
  if (has_frame_number(course_.scene)) return numbers_in(*course_.frames->range);
  const std::uint64_t there = scenes_->is_still() ? 1 : scenes_->count();
  still_ = there == 1;
  return still_ ? of_still() : of_trajectory(there);
}

std::vector<std::uint32_t> FilmFrames::of_still() const {
  const std::string file = printable(course_.scene, 4096);
  if (!path_ && course_.turntable == 0) {
    throw InputError(
        file +
        ": it shows one frame, so all frames of the film would be equal: add --turntable "
        "360 or --camera-path, or name a trajectory without --frame");
  }
  if (course_.frames && !(path_ && course_.frames->range)) {
    throw InputError("--frames: " + file + " shows one frame: use --count N instead");
  }
  if (course_.frames) return numbers_in(*course_.frames->range);
  if (path_ && !course_.count) {
    if (path_->last() - path_->first() < limits::max_frames) {
      return numbers_in({path_->first(), path_->last(), 1});
    }
    throw InputError("--camera-path: the path has more than " + std::to_string(limits::max_frames) +
                     " frames, the limit: choose some with --frames FIRST:LAST:STEP");
  }
  return numbers_in({0, course_.count.value_or(usual_count) - 1, 1});
}

std::vector<std::uint32_t> FilmFrames::of_trajectory(std::uint64_t there) const {
  const std::string file = printable(course_.scene, 4096);
  if (course_.count) {
    throw InputError("--count: " + file + " has " + std::to_string(there) +
                     " frames: choose some of them with --frames, or one with --frame");
  }
  if (course_.frames && course_.frames->range) {
    const FrameRange& range = *course_.frames->range;
    if (range.number(range.count() - 1) < there) return numbers_in(range);
    throw InputError("--frames: " + file + " has " + std::to_string(there) + " frames, 0 to " +
                     std::to_string(there - 1) + ": write at most " +
                     range_up_to(there - 1, range));
  }
  if (there <= limits::max_frames) return numbers_in({0, static_cast<std::uint32_t>(there - 1), 1});
  throw InputError("--frames: " + file + " has " + std::to_string(there) +
                   " frames, more than the limit of " + std::to_string(limits::max_frames) +
                   ": choose some, such as 0:" + std::to_string(there - 1) + ":" +
                   std::to_string(there / limits::max_frames + 1));
}

std::uint32_t FilmFrames::place_of(std::uint32_t frame) const {
  return static_cast<std::uint32_t>(std::ranges::lower_bound(numbers_, frame) - numbers_.begin());
}

std::vector<std::string> FilmFrames::files() const {
  std::vector<std::string> files = scenes_->files(numbers_);
  if (path_) files.push_back(course_.camera_path);
  return files;
}

void FilmFrames::move_camera(std::uint32_t frame, SceneFile& scene) const {
  if (path_) {
    scene.scene.camera = path_->at(frame);
    scene.postprocessing.depths = {};  // those of another camera
  }
  if (course_.turntable == 0) return;
  // Scene files that are numbered have cameras of their own.
  const bool own = has_frame_number(course_.scene) && scenes_->is_scene();
  const TurnAxis axis = own ? axis_of(scene.scene.camera) : scenes_->axis();
  turn(scene, axis, angle_at(course_.turntable, place_of(frame), count()));
}

double angle_at(double turntable, std::uint32_t place, std::uint32_t count) {
  return turntable * place / count;
}

}  // namespace parray::commands
