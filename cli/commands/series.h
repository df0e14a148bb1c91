#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "cli/commands/options.h"
#include "cli/farm/client.h"
#include "cli/output/frame_names.h"

/// A series of frames on the client's side: `submit --frames`, `film` and `fetch`.
namespace parray::commands {

/// Frames to render, and what becomes of them.
struct FrameJobs {
  std::vector<std::uint32_t> frames;  ///< their numbers, ascending; not empty
  std::set<std::uint32_t> there{};    ///< those of `frames` to skip: their pictures exist already
  /// Loads a frame. Throws InputError.
  std::function<Submission(std::uint32_t)> load;
  /// Fetches and writes a frame that is done. Returns the exit status. Throws InputError or
  /// RunError. Empty: the frames are only submitted.
  std::function<int(std::uint32_t frame, JobId job)> deliver{};
  /// Identifies the series: an equal token finds the frames that were submitted before. At most 48
  /// characters. Empty: each frame is a job of its own, which is deleted after deliver().
  std::string token{};
  /// Largest number of frames that are submitted and not yet delivered.
  std::size_t most_unfinished = std::numeric_limits<std::size_t>::max();
  /// If the first frame that this run loads cannot be loaded, run_frames() throws InputError and
  /// tries no other frame. No effect if frames of an earlier run are still to be delivered.
  bool first_must_load = false;
  bool wait = true;  ///< until all frames have ended
  /// `preview` is empty. `on_end` runs when all frames of a series have ended, if `wait`.
  ProgressOptions following{};
  std::string image{};  ///< PARRAY_IMAGE for `on_end`
  /// Print the number of the series on stdout. true also means that `deliver` prints lines.
  bool prints = true;
};

/// Returns a token for FrameJobs: the same for the same request of the same user of this machine.
std::string series_token(const std::string& request);

/// Loads and submits the frames one after the other. Skips frames that an earlier run with the same
/// token has submitted. With `wait`, delivers each frame when it is done, also those of an earlier
/// run. If a frame cannot be loaded or delivered, or fails, continues with the others and prints
/// the reason on stderr at the end. Returns the exit status: the largest that deliver() returned,
/// and at least 1 if a frame has no picture. Throws Interrupted, RunError if the series is
/// cancelled before all frames are submitted or the coordinator cannot be reached, and InputError
/// as `first_must_load` says.
int run_frames(Client& client, const FrameJobs& jobs);

/// Returns the outputs of a frame: its number replaces #### in their names.
OutputPaths outputs_of(const OutputPaths& outputs, std::uint32_t frame);

/// Throws InputError unless the name of each output contains #### for the frame's number. Also
/// throws as check_outputs() does for the outputs of frame 0.
void check_frame_outputs(const OutputPaths& outputs);

/// Fetches the finished frames of a series. For every other frame that was submitted, prints on
/// stderr why it has no picture. Returns the exit status: 1 if there is such a frame. `raw`: see
/// fetch_and_write(). Throws InputError if the job is not a series, or an output is one of the
/// `inputs`.
int fetch_series(Client& client, JobId series, const OutputPaths& outputs, const InputFiles& inputs,
                 bool raw);

}  // namespace parray::commands
