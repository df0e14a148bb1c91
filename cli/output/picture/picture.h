#pragma once

#include <nlohmann/json.hpp>

#include "cli/output/picture/channels.h"
#include "common/image/image.h"
#include "common/image/picture_bytes.h"

namespace parray::picture {

/// A finished picture and the coordinator's report about it.
struct Picture {
  Image image;
  PictureStatistics statistics;  ///< may be empty unless requested
  nlohmann::json report;
  Channels channels{};  ///< extra channels of the file; the client adds them
  Channels traced{};    ///< channels for postprocessing; no file contains them
};

}  // namespace parray::picture
