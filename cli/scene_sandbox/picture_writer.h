#pragma once

#include <cstddef>
#include <string>

#include "cli/scene_sandbox/limits.h"

namespace parray::scene_sandbox {

/// A file of a picture to write.
struct PictureRequest {
  std::string wanted;  ///< its name, which determines its kind: image.png, error.f32 ...
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t thumbnail_width = 0;  ///< width of a smaller copy in pixels; 0: no copy
  /// Denoises the picture first. `pixels` then also contains the replicates.
  bool denoise = false;
  bool draw = false;  ///< draws what the file `drawing` says (cli/commands/drawing.h)
  // With either, two more files exist: `scene`, the bytes of the scene, and `settings`, JSON.
};

/// Writes the file `wanted` from `pixels` and `report` in the current directory. Throws RunError.
void write_picture_file(const PictureRequest& request, const ChildResources& resources);

}  // namespace parray::scene_sandbox
