#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "cli/output/picture/channels.h"
#include "cli/output/picture/image_metadata.h"
#include "common/image/image.h"

namespace parray::picture {

/// Throws InputError unless an image can be written to `path`: the extension is one that
/// write_image() knows (.exr, .png, .tif, .tiff, .jpg, .jpeg or .jp2, in either case) and the place
/// is writable (check_output_path).
void check_image_path(const std::filesystem::path& path);

/// True where write_image() has room for more channels than RGB: .exr.
bool can_hold_channels(const std::filesystem::path& path);
/// True if files of that kind can hold alpha: all kinds but JPEG.
bool can_hold_alpha(const std::filesystem::path& path);

/// What decides how long writing takes.
struct PictureSize {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::size_t channels = 0;  ///< beside RGB
};

/// How long write_image() takes, about, on a core of some 2 GHz that has nothing else to do.
double write_seconds(const std::filesystem::path& path, const PictureSize& size, bool fast);

/// Writes `image`; `path` shows the whole file or what was there before, never a part.
///
/// EXR: the very floats, linear RGB with the chromaticities of Rec. ITU-R BT.709, losslessly
/// compressed (zip) unless `fast`, and every one of `channels`, each with a value for every pixel
/// and a name of its own, as FLOAT or UINT. PNG: srgb_bytes(), with an sRGB chunk of intent 0
/// (perceptual); `fast` does not compress. Of `channels` it holds alpha alone (transparency.h),
/// then as transparent_bytes(); others there must not be. TIFF (zip), JPEG (quality 95) and JPEG
/// 2000 hold the same bytes as PNG; TIFF keeps metadata as JSON in its ImageDescription, the two
/// others keep none. `metadata` as as_kept() has them: attributes of EXR, text of PNG.
/// `between_strips`, if set, is called every few milliseconds of writing; what it throws ends the
/// writing. Throws RunError "writing FILE: reason".
void write_image(const std::filesystem::path& path, const Image& image,
                 const ImageMetadata& metadata, const Channels& channels = {},
                 const std::function<void()>& between_strips = {}, bool fast = false);

/// The same of a picture that is soon replaced, in haste: not compressed, marked as
/// "parray:partial", and lost if the machine fails now.
void write_preview(const std::filesystem::path& path, const Image& image,
                   const std::function<void()>& between_strips);

/// What a picture file holds, as linear RGB (integers: the sRGB curve undone, and premultiplied),
/// metadata (single text and numbers) and the other channels, sorted by name: of an EXR file UINT
/// as whole numbers, HALF as floats; of a PNG file alpha, unless it is 1 everywhere. Its contents
/// say which of the two it is, not its name.
struct ImageFile {
  Image image;
  ImageMetadata metadata;
  Channels channels;
  bool high_dynamic_range = false;  ///< EXR, float TIFF ...: may lie outside [0, 1]
};

/// Throws InputError "FILE: reason": also for what OpenImageIO cannot read, fewer than 3 channels,
/// and sides or pixels beyond common/scene/limits.h.
ImageFile read_image(const std::filesystem::path& path);

/// Versions of OpenImageIO and OpenEXR that run: "2.4.7".
std::string image_library_version();
std::string exr_library_version();

}  // namespace parray::picture
