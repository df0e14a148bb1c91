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
  std::string scene;        ///< with #### where each frame has a file of its own
  std::string camera_path;  ///< file; empty: none
  FrameRange frames;
  RenderOptions render;
  OutputPaths outputs;  ///< with #### for the number
  std::uint32_t priority = 50;
  std::uint32_t max_failures = 0;
  bool wait = false;
  ProgressOptions following;  ///< without preview; `on_end` runs when all frames have ended
};

/// Throws InputError unless every frame can be written to a file of its own.
void check_frame_outputs(const OutputPaths& outputs);

/// Loads and submits the frames one after the other and prints the number of the series. Skips
/// frames that an earlier, equal request has submitted. With `wait`, fetches each frame when it is
/// done. If a frame cannot be loaded or fails, a line on stderr says so and the others go on; the
/// exit status is then 1. Interruptible.
int submit_series(Client& client, const SeriesRequest& request);

/// Fetches the finished frames of a series. For every other frame a line on stderr says why there
/// is no picture. Returns the exit status.
int fetch_series(Client& client, JobId series, const OutputPaths& outputs);

}  // namespace parray::commands
