#include "cli/commands/film_frames.h"

#include <algorithm>
#include <string>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/scene/limits.h"

namespace parray::commands {
namespace {

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

/// Throws InputError unless the options of the course fit together.
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
