#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cli/output/picture/image_file.h"

/// Every kind of picture but EXR and PNG, by OpenImageIO: a module that is loaded when the first is
/// read or written, because the library brings 260 others. The seam between image_file.cpp, which
/// everybody links, and image_codec.cpp, which is the module.
namespace parray::picture {

/// Kinds that can be written.
enum class OtherKind : std::uint8_t { tiff, jpeg, jpeg2000 };

/// What such a file is to hold.
struct OtherPicture {
  OtherKind kind = OtherKind::tiff;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool alpha = false;
  std::vector<std::uint8_t> bytes{};  ///< three a pixel, or four with alpha, top row first; sRGB
  std::string description{};          ///< kept in the file; empty: none
  double dpi = 0;                     ///< pixels an inch when printed; 0: not said
};

struct ImageCodec {
  /// Empty, or why the file could not be written.
  std::string (*write)(const std::string& file, const OtherPicture& picture);
  /// A file of any kind that the library knows, as read_image() has it.
  ImageFile (*read)(const std::string& file);
  /// image_library_version().
  std::string (*version)();
};

/// The one name that the module exports.
using ImageCodecEntry = const ImageCodec* (*)();
inline constexpr const char* image_codec_entry = "parray_image_codec";

}  // namespace parray::picture
