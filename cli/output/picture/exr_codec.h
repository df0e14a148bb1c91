#pragma once

#include <functional>
#include <string>

#include "cli/output/picture/image_file.h"

/// EXR files, by OpenEXR: a module that is loaded when the first is read or written, because its
/// libraries take ten milliseconds that no other command is to wait for. The seam between
/// image_file.cpp, which everybody links, and exr_codec.cpp, which is the module.
namespace parray::picture {

struct ExrCodec {
  /// Empty, or why the file could not be written. Arguments as write_image() has checked them;
  /// `metadata` of as_kept(). What `between_strips` throws passes through.
  std::string (*write)(const std::string& file, const Image& image, const ImageMetadata& metadata,
                       const Channels& channels, const std::function<void()>& between_strips,
                       bool fast);
  /// The first part of a file that begins as EXR files do, as read_image() has it.
  ImageFile (*read)(const std::string& file);
  /// Of OpenEXR: "3.1.5".
  std::string (*version)();
};

/// The one name that the module exports.
using ExrCodecEntry = const ExrCodec* (*)();
inline constexpr const char* exr_codec_entry = "parray_exr_codec";

}  // namespace parray::picture
