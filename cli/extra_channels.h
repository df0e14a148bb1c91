#pragma once

#include <functional>
#include <string>

#include "cli/client.h"
#include "common/image/channels.h"

namespace parray {

/// Extra channels of a picture. Most are traced from the scene, by whoever writes the picture: no
/// farm knows of them. Without any of these, nothing of the scene is kept.
struct ExtraChannels {
  Aovs aovs;
  RenderSettings settings;  ///< resolved
  std::string scene_bytes;  ///< scene_to_bytes()
  int threads = 1;
};

/// Those of a job of `settings` and `scene_bytes`, to be traced by `threads` threads here.
ExtraChannels extra_channels(const Aovs& aovs, const RenderSettings& settings,
                             const std::string& scene_bytes, int threads);

/// Whether the picture has to come with its statistics.
bool wants_statistics(const Aovs& aovs);

/// Adds them to the picture: what is traced, and what its statistics say. Its report gets `aovs`,
/// their names, and `seconds.aovs`. Throws Interrupted (see cli/interrupt.h).
void add_channels(Picture& picture, const ExtraChannels& extra);

}  // namespace parray
