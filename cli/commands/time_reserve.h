#pragma once

#include <functional>
#include <string>

#include "cli/commands/prepare.h"
#include "cli/output/picture/image_file.h"

/// Reserves the part of a command's --time-limit that tracing may not use.
namespace parray::commands {

/// The time for one picture: a command's time limit, or an equal share of it if the command renders
/// several pictures. Tracing gets what the other steps of the picture leave of it.
struct TimeShare {
  double seconds = 0;  ///< length of the share; 0 or less: the limit has passed
  std::string name;    ///< name of the limit in messages: "--time-limit 10"
  /// The part of `seconds` for writing files and ending the process.
  double writing = 0;
  std::function<double()> elapsed{};  ///< returns the seconds since the share began
  /// Number of pictures that are not rendered yet, including this one.
  double parts = 1;
  /// Seconds of the limit before this share, and after the last one.
  double elsewhere = 0;

  // Each flag is set when the first picture leaves the step out; a line on stderr then says so.
  // Later pictures of the command leave the step out, too, without a line.
  bool without_denoising = false;  ///< there is no time for denoising
  bool without_channels = false;   ///< there is no time for tracing extra channels, such as depth
  bool without_time = false;  ///< there is no time for tracing: as little as possible is traced
};

/// Returns the seconds for writing the picture, the preview and the error map of `outputs`, and for
/// ending the process. `limit`: the command's time limit in seconds. If writing the picture would
/// take more than a tenth of it, assumes that the picture is written with weaker, faster
/// compression.
double writing_seconds(const OutputPaths& outputs, const PictureSize& size, double limit);

/// Returns the seconds of the share that tracing may not use: those that have passed, and those for
/// denoising, extra channels, drawing and writing. (The coordinator subtracts its own steps
/// itself.) If denoising does not fit into the share, removes it from `render`, sets the flag in
/// `share` and prints a line on stderr. Then does the same with extra channels.
double reserve_time(TimeShare& share, PreparedRender& render);

}  // namespace parray::commands
