#pragma once

#include <functional>
#include <string>

#include "cli/output/picture/image_file.h"

/// Reads and writes EXR files with OpenEXR. The program loads this module for the first EXR file,
/// because loading OpenEXR's libraries takes ten milliseconds. This header is the interface between
/// image_file.cpp in the program and exr_codec.cpp in the module.
namespace parray::picture {

/// The functions of the module.
struct ExrCodec {
  /// Writes a file. Returns "" on success, otherwise the reason. write_image() has checked the
  /// arguments. `metadata` has the form of as_kept() (image_metadata.h). `fast`: no compression.
  /// Passes on exceptions of `between_strips`.
  std::string (*write)(const std::string& file, const Image& image, const ImageMetadata& metadata,
                       const Channels& channels, const std::function<void()>& between_strips,
                       bool fast);
  /// Reads an EXR file; of a file with several parts, the first part. Throws InputError as
  /// read_image() does.
  ImageFile (*read)(const std::string& file);
  /// Returns the version of OpenEXR that the module was built with: "3.1.5".
  std::string (*version)();
};

/// The only symbol that the module exports.
using ExrCodecEntry = const ExrCodec* (*)();
inline constexpr const char* exr_codec_entry = "parray_exr_codec";

}  // namespace parray::picture
