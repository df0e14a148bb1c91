#pragma once

#include "cli/output/extra_channels.h"

namespace parray::output {

/// What is done to a picture between tracing and writing, by this machine as it is now. Seconds.
struct EndingCost {
  double denoising = 0;
  double channels = 0;  ///< extra channels, also those that finishing steps need
  /// Of tracing's time, what taking the background out takes: it traces the camera rays again.
  double background_share = 0;
};

/// Does it all to a miniature of the picture, with at most an eighth of its pixels, and scales the
/// times up. Builds the accelerator, or takes that of `extra`. `scene_id`: the scene's identity.
EndingCost ending_cost(const ExtraChannels& extra, const std::string& scene_id);

}  // namespace parray::output
