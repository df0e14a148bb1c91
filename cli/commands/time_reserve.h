#pragma once

#include <functional>
#include <string>

#include "cli/commands/prepare.h"
#include "cli/output/picture/image_file.h"

/// Reserves the part of a command's --time-limit that tracing may not use.
namespace parray::commands {

/// The time for one picture: a command's time limit. If the command renders several pictures, the
/// remaining ones divide the remaining time equally. Tracing gets what the other steps of the
/// picture leave of the share.
struct TimeShare {
  double seconds = 0;  ///< length of the share; 0 or less: the limit has passed
  std::string name;    ///< name of the limit in messages: "--time-limit 10"
  /// The part of `seconds` for writing files, see writing_seconds().
  double writing = 0;
  std::function<double()> elapsed{};  ///< returns the seconds since the share began
  /// Number of pictures that are not rendered yet, including this one. Messages state the seconds
  /// of a step for all of them.
  double parts = 1;
  /// Seconds of the limit that belong to no remaining share: those before this share, and those
  /// for joining and writing after the last one.
  double elsewhere = 0;

  // reserve_time() sets a flag, and prints a line on stderr, when the first picture lacks the time.
  // Later pictures leave the same steps out, without a line.
  bool without_denoising = false;  ///< there is no time for denoising
  bool without_channels = false;   ///< there is no time for tracing extra channels, such as depth
  /// There was no time for tracing: as little as possible was traced. Only keeps later pictures
  /// from printing the line again.
  bool without_time = false;
};

/// Returns the seconds for writing the picture, the preview and the error map of `outputs`, and for
/// starting and ending the process. `limit`: the command's time limit in seconds. If writing the
/// picture would take more than a tenth of the limit, assumes that EXR and PNG files are written
/// without compression.
double writing_seconds(const OutputPaths& outputs, const PictureSize& size, double limit);

/// Returns the seconds of the share that tracing may not use: those that have passed, and those for
/// denoising, extra channels, removing the background, drawing and writing. (The coordinator
/// subtracts its own steps itself.)
///
/// Tracing needs at least 15 % of the share. If denoising leaves less, removes it from `render`,
/// sets the flag in `share` and prints a line on stderr. Then does the same with extra channels and
/// the postprocessing that needs them. Sets `without_time` and prints a line if the remaining steps
/// take longer than the share.
double reserve_time(TimeShare& share, PreparedRender& render);

}  // namespace parray::commands
