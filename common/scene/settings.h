#pragma once

#include "common/scene/picture_settings.h"
#include "common/scene/setting_choices.h"
#include "common/scene/settings_fwd.h"
#include "common/scene/stop_settings.h"

namespace parray::scene {

/// How the work is divided and done. These settings never change the bits of a picture.
struct WorkSettings {
  AcceleratorKind accelerator = AcceleratorKind::automatic;
  Isa isa = Isa::automatic;  ///< a worker that lacks it takes the best it has
  SchedulePolicy schedule = SchedulePolicy::weighted;
  RowOrder row_order = RowOrder::automatic;  ///< automatic: interleaved with weighted
  bool progressive = false;  ///< trace one sample of every pixel first, for an early preview
  bool replicates = false;   ///< keep the two halves of the samples (image/picture_bytes.h)

  friend bool operator==(const WorkSettings&, const WorkSettings&) = default;
};

/// How a scene is to be rendered. Without a time limit, the scene, PictureSettings and StopSettings
/// determine the bits of the picture. A function takes the part that it needs.
struct RenderSettings : PictureSettings, StopSettings, WorkSettings {
  [[nodiscard]] const PictureSettings& picture() const { return *this; }
  [[nodiscard]] const StopSettings& stop() const { return *this; }
  [[nodiscard]] const WorkSettings& work() const { return *this; }

  /// Returns whether there may be passes after the first.
  [[nodiscard]] bool has_passes() const { return in_passes() || progressive; }

  friend bool operator==(const RenderSettings&, const RenderSettings&) = default;
};

/// Throws InputError that names the first value out of its range.
void check_settings(const RenderSettings& settings);

}  // namespace parray::scene
