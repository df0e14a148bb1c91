#include "cli/scene_sandbox/upload_jobs.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "cli/commands/drawing.h"
#include "cli/commands/frame_scenes.h"
#include "cli/commands/prepare.h"
#include "cli/input/view/free_area.h"
#include "common/base/error.h"
#include "common/scene/limits.h"
#include "common/scene/settings.h"
#include "proto/clock.h"

namespace parray::scene_sandbox {
namespace {

using nlohmann::json;

/// Writes the messages of a batch.
class Batch {
 public:
  void add(msg::Submit message) {
    message.token = "to be replaced";
    const Frames frames = encode(message);
    const std::string number = std::to_string(jobs_++);
    keep_bytes("../control-" + number, frames.at(0).view());
    keep_bytes("../bulk-" + number, frames.at(1).view());
    bytes_ += frames.at(1).view().size();
  }
  [[nodiscard]] std::size_t jobs() const { return jobs_; }
  /// Returns whether the server should take these messages before more are made.
  [[nodiscard]] bool full() const {
    constexpr std::size_t most_jobs = 256;
    constexpr std::uint64_t most_bytes = std::uint64_t{64} << 20;
    constexpr Time longest = seconds(10);
    const bool late = jobs_ > 0 && clock_.now() - begin_ >= longest;
    return jobs_ >= most_jobs || bytes_ >= most_bytes || late;
  }
  /// Writes the description of the batch. `frames`: number of frames of the series; 0: single job.
  void finish(std::size_t frames) const {
    keep_bytes("../batch", json{{"frames", frames}, {"jobs", jobs_}}.dump());
  }

 private:
  SteadyClock clock_;
  Time begin_ = clock_.now();
  std::size_t jobs_ = 0;
  std::uint64_t bytes_ = 0;
};

/// Returns whether the pictures of the job are denoised: as the option says, else as --quality.
bool wants_denoising(const UploadRequest& request, const RenderSettings& settings) {
  const Quality* const quality = request.render.quality();
  const bool usual = quality != nullptr && quality->denoise && settings.samples_per_pixel >= 2;
  return request.denoise.value_or(usual);
}

/// Returns what is drawn on the picture. If the labels of the scene itself do not fit a small
/// picture, such as a preview, leaves them out.
std::string drawing_of(const UploadRequest& request, SceneFile& file, const Submission& job) {
  const auto text = [&] {
    return drawing_text(request.labels, request.postprocessing, file, job.scene, job.settings);
  };
  try {
    return text();
  } catch (const InputError&) {
    const bool asked =
        !request.labels.first_given().empty() || !request.postprocessing.first_given().empty();
    if (asked || !file.labels.any()) throw;
  }
  file.labels = {};
  return text();
}

Submission submission_of(const UploadRequest& request, LoadedSubmission loaded) {
  Submission submission = std::move(loaded.submission);
  submission.max_failures = request.max_failures;
  submission.settings->progressive = request.progressive;
  if (!request.name.empty()) submission.name = request.name;
  submission.drawing = drawing_of(request, loaded.rest, submission);
  submission.denoise = wants_denoising(request, submission.settings);
  if (submission.denoise) {
    ask_for_denoising(submission.settings, RenderMode::http, !request.render.has_target_error());
  }
  return submission;
}

/// Returns the range of frames. Counts those of the file if all are wanted. Throws InputError.
FrameRange range_of(const ChosenFrames& chosen, FrameScenes& scenes) {
  if (chosen.range) return *chosen.range;
  const std::uint64_t count = scenes.count();
  if (count > limits::max_frames) {
    throw InputError("--frames: the trajectory has " + std::to_string(count) +
                     " frames, more than the limit of " + std::to_string(limits::max_frames) +
                     ": choose some, such as \"0:" + std::to_string(limits::max_frames - 1) + "\"");
  }
  return {0, static_cast<std::uint32_t>(count - 1), 1};
}

/// Returns the result of `work`. Begins its errors with the number of the frame, except those of
/// labels, which all frames have.
auto of_frame(std::uint32_t frame, const auto& work) {
  try {
    return work();
  } catch (const LabelError&) {
    throw;
  } catch (const InputError& error) {
    throw InputError("frame " + std::to_string(frame) + ": " + error.what());
  }
}

void fix(const FrameRange& range, FrameScenes& scenes) {
  of_frame(range.first, [&] { scenes.fix({range.first}); });
}

/// Throws InputError if the last frame cannot be read. A series that lacks frames never ends, so
/// this comes before its first job.
void check_last(const FrameRange& range, FrameScenes& scenes) {
  const std::uint32_t last = range.number(range.count() - 1);
  if (last != range.first) of_frame(last, [&] { scenes.at(last); });
}

void add_frames(const UploadRequest& request, std::size_t first, Batch& batch) {
  FrameScenes scenes(request.scene, request.render, NamedFiles::beside);
  const FrameRange range = range_of(*request.frames, scenes);
  fix(range, scenes);
  if (first == 0) check_last(range, scenes);
  for (std::size_t place = first; place < range.count() && !batch.full(); ++place) {
    const std::uint32_t frame = range.number(static_cast<std::uint32_t>(place));
    try {
      Submission submission = of_frame(frame, [&] {
        return submission_of(request,
                             load_frame(RenderMode::http, scenes, frame, request.priority));
      });
      submission.frame = frame;
      submission.frames = range.count();
      batch.add(submit_message(std::move(submission)));
    } catch (const InputError&) {
      if (batch.jobs() > 0) break;  // the next batch says why
      throw;
    }
  }
  batch.finish(range.count());
}

}  // namespace

void add_upload_options(Command& command, UploadRequest& request) {
  command.option("--name", request.name, "Name of the job; default: the file name of the scene");
  add_whole_number(command, "--priority", 0, 100, request.priority,
                   "Of the jobs of a user, those with a higher priority are rendered first");
  add_whole_number(command, "--max-failures", 1, 1000, request.max_failures,
                   "The job fails if so many machines that trace other parts of it have failed at "
                   "the same part. It also fails if all machines have failed there, and they are "
                   "so many, or each has at least two failures for each of its workers");
  command.flag("--progressive", request.progressive, "Trace a preview of all pixels first");
  command.on_off("--denoise", request.denoise,
                 "Denoise the finished picture. image.exr then also contains the picture before "
                 "denoising, in the channels raw.R, raw.G, raw.B");
  command.option(
      "--frames",
      [&request](const std::string& text) { request.frames = chosen_frames_from(text); },
      "Make a series with a job for each frame of the trajectory: all, 7, 0:100 or 0:100:5 "
      "(first, last, step). A particle file alone has the camera of the first chosen frame. Each "
      "frame has its own ranges of colours and radii, and its own colours of names");
  request.render.add_to(command);
  request.render.add_quality_to(command);
  request.postprocessing.add_to(command, nullptr);
  request.labels.add_to(command, nullptr, request.render);
}

Submission first_submission(const UploadRequest& request, std::size_t& frames) {
  frames = 1;
  if (!request.frames) {
    return submission_of(request, load_submission(RenderMode::http, request.scene, request.render,
                                                  request.priority));
  }
  FrameScenes scenes(request.scene, request.render, NamedFiles::beside);
  const FrameRange range = range_of(*request.frames, scenes);
  fix(range, scenes);
  check_last(range, scenes);
  frames = range.count();
  return submission_of(request,
                       load_frame(RenderMode::http, scenes, range.first, request.priority));
}

void write_upload_jobs(const UploadRequest& request, std::size_t first,
                       const ChildResources& resources) {
  confine(resources, resources.memory);
  Batch batch;
  if (request.frames) return add_frames(request, first, batch);
  std::size_t frames = 0;
  batch.add(submit_message(first_submission(request, frames)));
  batch.finish(0);
}

}  // namespace parray::scene_sandbox
