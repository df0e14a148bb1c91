#pragma once

#include <functional>
#include <string>

#include "cli/commands/prepare.h"
#include "cli/output/picture/image_file.h"

/// The part of a command's --time-limit that is not for tracing.
namespace parray::commands {

/// A command's time limit, or the share of it that one of several pictures gets.
struct TimeShare {
  double seconds = 0;                 ///< length of the share; 0 or less: no time is left
  std::string name;                   ///< name of the limit in messages: "--time-limit 10"
  double writing = 0;                 ///< seconds for writing files and ending the process
  std::function<double()> elapsed{};  ///< returns the seconds of the share that have passed
  double parts = 1;                   ///< number of remaining equal shares, including this one
  double elsewhere = 0;               ///< seconds of the limit outside all shares

  // Set when a line on stderr has reported it. Later pictures of the command print no line.
  bool without_denoising = false;
  bool without_channels = false;
  bool without_time = false;  ///< no time is left for tracing
};

/// Returns the seconds for writing the picture, the preview and the error map of `outputs`, and for
/// ending the process. If the picture would take more than a tenth of `limit`, assumes fast
/// writing.
double writing_seconds(const OutputPaths& outputs, const PictureSize& size, double limit);

/// Does the same for a share of a limit as reserve_time() in prepare.h for a whole limit. Returns
/// the seconds that the command itself needs: those that have passed, and those after tracing.
double reserve_time(TimeShare& share, PreparedRender& render);

}  // namespace parray::commands
