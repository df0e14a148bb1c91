#pragma once

#include <cstddef>
#include <string>

#include "cli/scene_sandbox/confinement.h"

namespace parray::scene_sandbox {

/// A file of a picture to write. All files are in the current directory.
struct PictureRequest {
  /// Name of the new file. pixels.f32: the floats of the picture. error.f32: the half-widths.
  /// error.png: the map of the error. Any other name: the picture, in the format of the extension.
  /// With a thumbnail_width, the file is a picture, whatever its name.
  std::string wanted;
  std::size_t width = 0;  ///< of the whole picture, in pixels
  std::size_t height = 0;
  std::size_t thumbnail_width = 0;  ///< width in pixels of a smaller picture; 0: the whole picture
  /// Denoises the picture first. The file `pixels` must then contain the replicates, too.
  bool denoise = false;
  bool draw = false;  ///< draws what the file `drawing` says (cli/commands/drawing.h)
  // denoise and draw need two more files: `scene`, the bytes of the scene, and `settings`, JSON.
};

/// Confines this process (confinement.h). Reads the files `pixels` (common/image/picture_bytes.h)
/// and `report`, and writes the file `wanted`. Throws RunError if the process cannot be confined,
/// or a file cannot be read or written.
void write_picture_file(const PictureRequest& request, const ChildResources& resources);

}  // namespace parray::scene_sandbox
