#pragma once

#include <functional>
#include <string>

#include "cli/output/delivery.h"
#include "cli/output/extra_channels.h"
#include "cli/output/picture/image_file.h"

/// What a command with --time-limit keeps of its time for all that is not tracing.
namespace parray::commands {

/// A command's time limit, or the part of it that one of several pictures gets.
struct TimeShare {
  double seconds = 0;                 ///< not above 0: nothing is left
  std::string name;                   ///< of the limit, for messages: "--time-limit 10"
  double writing = 0;                 ///< seconds of it for writing files and ending the process
  std::function<double()> elapsed{};  ///< seconds of it that have passed
  double parts = 1;                   ///< such shares that are left of the limit, this one included
  double elsewhere = 0;               ///< seconds of the limit that no share has

  // Set once stderr has a line about it; later pictures of the command follow without a line.
  bool without_denoising = false;
  bool without_channels = false;
  bool without_time = false;  ///< for tracing
};

/// The whole limit of a command that renders one picture. `elapsed`: seconds since its start.
TimeShare whole_limit(const OutputPaths& outputs, const RenderSettings& settings,
                      std::function<double()> elapsed);

/// Seconds for writing the image, the preview and the error map of `outputs`, and for ending the
/// process. Writing the image in haste counts where it would take more than a tenth of `limit`.
double writing_seconds(const OutputPaths& outputs, const PictureSize& size, double limit);

/// Returns the seconds of `share` that are needed beside the coordinator's part: those that have
/// passed, and what follows tracing. Denoising, and then extra channels with the steps that need
/// them, are left out of `outputs`, `settings` and `extra` where they do not fit. A line on stderr
/// says so, and one says that nothing is left for tracing: each once for a share.
double reserve_time(TimeShare& share, OutputPaths& outputs, RenderSettings& settings,
                    ExtraChannels& extra, const std::string& scene_id);

}  // namespace parray::commands
