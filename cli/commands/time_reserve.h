#pragma once

#include <functional>
#include <string>

#include "cli/commands/prepare.h"
#include "cli/output/picture/image_file.h"

/// The part of a command's --time-limit that is not for tracing.
namespace parray::commands {

/// A command's time limit, or the part of it that one of several pictures gets.
struct TimeShare {
  double seconds = 0;                 ///< 0 or less: nothing is left
  std::string name;                   ///< of the limit, for messages: "--time-limit 10"
  double writing = 0;                 ///< seconds of it for writing files and ending the process
  std::function<double()> elapsed{};  ///< seconds of it that have passed
  double parts = 1;                   ///< equal shares left of the limit, including this one
  double elsewhere = 0;               ///< seconds of the limit outside all shares

  // Set after a line on stderr has said so. Later pictures of the command print no line.
  bool without_denoising = false;
  bool without_channels = false;
  bool without_time = false;  ///< for tracing
};

/// Seconds for writing the image, the preview and the error map of `outputs`, and for ending the
/// process. If writing the image would take more than a tenth of `limit`, fast writing counts.
double writing_seconds(const OutputPaths& outputs, const PictureSize& size, double limit);

/// The same as reserve_time() of a whole limit, for a share of a limit. Returns the seconds that
/// the render needs beside the coordinator's part: those that have passed, and those after tracing.
double reserve_time(TimeShare& share, PreparedRender& render);

}  // namespace parray::commands
