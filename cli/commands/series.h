#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/commands/options.h"
#include "cli/farm/client.h"
#include "cli/output/frame_names.h"

/// A series of frames from the client's side: `submit --frames`, and `fetch` of one.
namespace parray::commands {

/// What `submit --frames` is asked for.
struct SeriesRequest {
  std::string scene;        ///< with #### where each frame has a file of its own
  std::string camera_path;  ///< file; empty: none
  FrameRange frames;
  RenderOptions render;
  OutputPaths outputs;  ///< with #### for the number
  std::uint32_t priority = 50;
  std::uint32_t max_failures = 0;
  bool wait = false;
  ProgressOptions following;  ///< without a preview; `on_end` is run once all frames have ended
};

/// Throws InputError unless the pictures of frames can be written there, each to a file of its own.
void check_frame_outputs(const OutputPaths& outputs);

/// Loads and submits the frames one after the other, but for those that an earlier, equal request
/// has submitted, and prints the series' number; with `wait`, fetches each as it is done. A frame
/// that cannot be loaded, or fails, has a line on stderr and does not keep the others. Returns the
/// exit status: 1 if there was such a frame. Interruptible.
int submit_series(Client& client, const SeriesRequest& request);

/// Fetches the frames of a series that are done; the others have a line on stderr each. Returns the
/// exit status.
int fetch_series(Client& client, JobId series, const OutputPaths& outputs);

}  // namespace parray::commands
