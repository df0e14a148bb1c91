#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/output/picture/image_file.h"

/// Reads and writes all kinds of picture files except EXR and PNG, with OpenImageIO. The program
/// loads this module for the first such file, because the library loads 260 others. This header is
/// the interface between image_file.cpp in the program and image_codec.cpp in the module.
namespace parray::picture {

/// File formats that can be written.
enum class OtherKind : std::uint8_t { tiff, jpeg, jpeg2000 };

/// The contents of such a file.
struct OtherPicture {
  OtherKind kind = OtherKind::tiff;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool alpha = false;
  std::vector<std::uint8_t> bytes{};  ///< sRGB, three per pixel or four with alpha, top row first
  std::string description{};          ///< stored in the file; empty: none
  double dpi = 0;                     ///< pixels per inch in print; 0: unknown
};

/// The functions of the module.
struct ImageCodec {
  /// Writes a file. Returns "" on success, otherwise the reason.
  std::string (*write)(const std::string& file, const OtherPicture& picture);
  /// Reads any file that the library supports. Throws InputError as read_image() does.
  ImageFile (*read)(const std::string& file);
  /// Returns the value of image_library_version().
  std::string (*version)();
};

/// The only symbol that the module exports.
using ImageCodecEntry = const ImageCodec* (*)();
inline constexpr const char* image_codec_entry = "parray_image_codec";

}  // namespace parray::picture
