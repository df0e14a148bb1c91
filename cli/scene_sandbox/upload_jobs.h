#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "cli/commands/options.h"
#include "cli/farm/client.h"
#include "cli/output/frame_names.h"
#include "cli/scene_sandbox/confinement.h"

namespace parray::scene_sandbox {

/// An uploaded scene and the job, or series of jobs, to make of it.
struct UploadRequest {
  std::string scene;  ///< name of its file in the current directory
  std::string name;   ///< of the job; empty: as the scene's file
  RenderOptions render;
  std::uint32_t priority = 50;
  std::uint32_t max_failures = 0;  ///< 0: as the coordinator's --max-failures
  bool progressive = false;
  std::optional<bool> denoise;  ///< nothing: as --quality
  LabelOptions labels;
  PostprocessOptions postprocessing;
  std::optional<ChosenFrames> frames;  ///< not given: a single job
};

/// Declares the options of an upload: those of POST /api/v1/jobs, with hyphens instead of
/// underscores. `request` must not move until the command line is parsed.
void add_upload_options(Command& command, UploadRequest& request);

/// Reads the scene in the current directory and makes the job. If the request makes a series, makes
/// the job of its first frame. Sets `frames` to the number of frames, or to 1 for a single job.
/// Throws InputError if the scene cannot be read.
Submission first_submission(const UploadRequest& request, std::size_t& frames);

/// Confines this process (confinement.h) and reads the scene in the current directory. Writes both
/// parts of each message `submit` (PROTOCOL.md) to ../control-N and ../bulk-N, with N from 0.
/// `first`: place in the series, from 0, of the first frame to read. Then writes ../batch, a JSON
/// map: `frames` is the number of frames of the series, 0 for a single job; `jobs` is the number of
/// messages. The batch ends before the last frame if it has 256 messages or 64 MiB, takes 10 s, or
/// a later frame cannot be read. The caller then starts the next process with `first` + `jobs`.
///
/// Throws InputError if the scene, or the first frame of the batch, cannot be read. Throws RunError
/// if the process cannot be confined, or a file cannot be written.
void write_upload_jobs(const UploadRequest& request, std::size_t first,
                       const ChildResources& resources);

/// Confines this process (confinement.h). Reads the scene in the current directory as
/// first_submission() does, traces a part of its picture for about two seconds on one thread, and
/// writes a forecast to ../forecast: a JSON map with the keys of the answer to POST /api/v1/plan,
/// except those that depend on the queue. `threads`: number of threads of all workers; with 0,
/// `seconds` is null. The times of a series are those of all frames together; the forecast assumes
/// that all frames are like the first one.
///
/// Throws InputError if the scene cannot be read, or the job's target is out of reach. Throws
/// RunError if the process cannot be confined, or the forecast cannot be written.
void write_forecast(const UploadRequest& request, std::size_t threads,
                    const ChildResources& resources);

}  // namespace parray::scene_sandbox
