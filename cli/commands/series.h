#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/commands/options.h"
#include "cli/farm/client.h"
#include "cli/output/frame_names.h"

/// A series of frames on the client's side: `submit --frames` and `fetch`.
namespace parray::commands {

/// The request of `submit --frames`.
struct SeriesRequest {
  std::string scene;        ///< with #### if each frame has its own file
  std::string camera_path;  ///< file of --camera-path; empty: none
  FrameRange frames;
  RenderOptions render;
  OutputPaths outputs;  ///< with #### for the frame's number
  std::string name;     ///< of all frames; empty: those of the scenes' files
  std::uint32_t priority = 50;
  std::uint32_t max_failures = 0;
  bool wait = false;
  ProgressOptions following;  ///< `preview` is empty; `on_end` runs when all frames have ended
};

/// Throws InputError unless the name of each output contains the frame's number.
void check_frame_outputs(const OutputPaths& outputs);

/// Loads and submits the frames one after the other and prints the number of the series. Skips
/// frames that an earlier, equal request has submitted. With `wait`, fetches each frame when it is
/// done. If a frame cannot be loaded or fails, prints a line on stderr, continues with the others,
/// and returns exit status 1. Throws Interrupted.
int submit_series(Client& client, const SeriesRequest& request);

/// Fetches the finished frames of a series. For every other frame, prints on stderr why it has no
/// picture. Returns the exit status. `raw`: see fetch_and_write().
int fetch_series(Client& client, JobId series, const OutputPaths& outputs, bool raw);

}  // namespace parray::commands
