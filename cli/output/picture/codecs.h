#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "cli/output/picture/image_file.h"
#include "common/base/error.h"
#include "common/scene/limits.h"

/// Readers and writers of the picture formats, which image_file.cpp calls. png_file.cpp is part of
/// the program. exr_codec.cpp and image_codec.cpp are modules: libraries that the program loads
/// when it needs them. Modules call only inline functions of the program.
namespace parray::picture {

/// File formats that can be written.
enum class Format : std::uint8_t { exr, png, tiff, jpeg, jpeg2000, unknown };

/// The functions of the module that reads and writes EXR files with OpenEXR. The program loads it
/// for the first EXR file, because loading OpenEXR's libraries takes ten milliseconds.
struct ExrCodec {
  /// Writes a file. Returns "" on success, otherwise the reason. write_image() has checked the
  /// arguments. `metadata` has the form of as_kept(). `fast`: no compression.
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

/// The contents of a file of another format than EXR and PNG.
struct OtherPicture {
  Format format = Format::tiff;  ///< TIFF, JPEG or JPEG 2000
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  bool alpha = false;
  std::vector<std::uint8_t> bytes{};  ///< sRGB, three per pixel or four with alpha, top row first
  std::string description{};          ///< stored in the file; empty: none
  double dpi = 0;                     ///< pixels per inch in print; 0: unknown
};

/// The functions of the module that reads and writes all kinds of picture files except EXR and PNG,
/// with OpenImageIO. The program loads it for the first such file, because the library loads 260
/// others.
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

/// Writes a PNG file of srgb_bytes(), or of transparent_bytes() with `alpha`, which has a value for
/// every pixel. Adds an sRGB chunk of intent 0 (perceptual) and `metadata` (text, as_kept()) before
/// the pixels; dpi_key also becomes a pHYs chunk. `fast`: no compression. Returns an empty text, or
/// why writing failed. Calls `between_strips`, if set, every few milliseconds of writing; it may
/// throw.
std::string write_png(const std::string& file, const Image& image, const ImageMetadata& metadata,
                      const std::function<void()>& between_strips, bool fast,
                      std::span<const float> alpha = {});

/// Reads a file that begins as a PNG file, as read_image() does. Throws InputError "FILE: reason".
ImageFile read_png(const std::string& path);

/// Throws InputError "FILE: reason" if a picture has no pixels, or too many pixels or channels.
/// `channels` is the number of all channels, including R, G and B. Each takes four bytes per pixel.
/// `path` is the file's name for the message.
inline void check_image_limits(const std::string& path, std::uint64_t width, std::uint64_t height,
                               std::size_t channels) {
  constexpr std::size_t most_channels = 256;
  // A small file may claim any size. ParRay's own largest picture has 64 bytes per pixel.
  constexpr std::uint64_t most_bytes = limits::max_pixels * 64;
  const auto refuse = [&](const std::string& reason) { throw InputError(path + ": " + reason); };
  if (width == 0 || height == 0) refuse("the picture has no pixels: name another file");
  if (channels > most_channels) refuse("the file has more than 256 channels: remove some");
  if (std::max(width, height) > limits::max_image_side || width * height > limits::max_pixels) {
    refuse(std::to_string(width) + " x " + std::to_string(height) +
           " pixels are too many: use at most " + std::to_string(limits::max_image_side) +
           " per side and " + std::to_string(limits::max_pixels) + " in total");
  }
  if (width * height * channels * 4 > most_bytes) {
    refuse(std::to_string(channels) + " channels have more than " + std::to_string(most_bytes) +
           " bytes: remove some");
  }
}

}  // namespace parray::picture
