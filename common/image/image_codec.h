#pragma once

#include <functional>
#include <string>

#include "common/image/image_file.h"

/// What needs OpenImageIO, a module that is loaded when the first picture is read, or the first EXR
/// file written: the library brings 260 others, and no command is to wait for them that needs none.
/// The seam between image_file.cpp, which everybody links, and image_codec.cpp, which is the
/// module.
namespace parray {

struct ImageCodec {
  /// Empty, or why the EXR file could not be written. Arguments as write_image() has checked them;
  /// `metadata` of as_kept().
  std::string (*write_exr)(const std::string& file, const Image& image,
                           const ImageMetadata& metadata, const Channels& channels,
                           const std::function<void()>& between_strips, bool fast);
  /// read_image().
  ImageFile (*read)(const std::string& file);
  /// image_library_version().
  std::string (*version)();
};

/// The one name that the module exports.
using ImageCodecEntry = const ImageCodec* (*)();
inline constexpr const char* image_codec_entry = "parray_image_codec";

}  // namespace parray
