#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "cli/output/picture/channels.h"
#include "common/image/image.h"

namespace parray::picture {

/// A text, an integer or a real number.
using MetadataValue = std::variant<std::string, std::uint64_t, double>;

/// Names and values in an image file, in order. A name that ParRay writes has letters, digits, '_'
/// and ':', at most 79 bytes (PNG's limit). The caller of a writer ensures that. If a name occurs
/// twice, the first value counts.
using ImageMetadata = std::vector<std::pair<std::string, MetadataValue>>;

/// Name of the pixels per inch in print. The value is a real number > 0.
inline constexpr const char* dpi_key = "parray:dpi";

/// Returns the value as text. A number becomes the shortest decimal text that reads back as the
/// same number.
std::string text_of(const MetadataValue& value);

/// Returns the values in the form that a file can store. `exr` true: an integer as `int`, from 2^31
/// on as `double`, above 2^53 as text; a real number as `double`. `exr` false: only text.
ImageMetadata as_kept(const ImageMetadata& metadata, bool exr);

/// Return the value that a file has stored under a name. text_in() returns only texts; the others
/// also convert texts and other numbers. Return nothing if the name is missing or the value does
/// not fit.
std::optional<std::string> text_in(const ImageMetadata& metadata, std::string_view name);
std::optional<std::uint64_t> whole_in(const ImageMetadata& metadata, std::string_view name);
std::optional<double> real_in(const ImageMetadata& metadata, std::string_view name);

/// Throws InputError unless write_image() can write to `path`: the extension is .exr, .png, .tif,
/// .tiff, .jpg, .jpeg or .jp2, in either case, the place is writable (check_output_path()), and
/// this ParRay has OpenImageIO or does not need it. Throws RunError if the module that writes EXR
/// files cannot be loaded.
void check_image_path(const std::filesystem::path& path);

/// Throws InputError if a file of this kind cannot contain a picture of this size.
void check_image_size(const std::filesystem::path& path, std::uint64_t width, std::uint64_t height);

/// Returns whether the file can contain more channels than RGB: .exr.
bool can_hold_channels(const std::filesystem::path& path);
/// Returns whether the file can contain alpha: all formats except JPEG.
bool can_hold_alpha(const std::filesystem::path& path);

/// The properties of a picture that determine how long writing takes.
struct PictureSize {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::size_t channels = 0;  ///< in addition to RGB
};

/// Returns about how long write_image() takes, in seconds, on an idle core of 2 GHz.
double write_seconds(const std::filesystem::path& path, const PictureSize& size, bool fast);

/// Writes `image`. `path` always contains the whole new file or the previous one.
///
/// EXR: the exact floats, linear RGB with the chromaticities of Rec. ITU-R BT.709, compressed
/// without loss (zip) unless `fast`, and all `channels`, as FLOAT or UINT. Each channel has a value
/// for every pixel and a unique name. PNG: srgb_bytes(), with an sRGB chunk of intent 0
/// (perceptual); `fast` does not compress. `channels` may then contain only alpha (transparency.h),
/// and the file holds transparent_bytes(). TIFF (zip), JPEG (quality 95) and JPEG 2000 hold the
/// same bytes as PNG. TIFF stores the metadata as JSON in ImageDescription; the other two store
/// none. `metadata`: see as_kept(); attributes of EXR, text of PNG. For EXR and PNG, calls
/// `between_strips`, if set, every few milliseconds of writing; an exception ends the writing.
/// Throws RunError "writing FILE: reason", InputError as check_image_size() does, and
/// std::logic_error for channels that the file cannot contain.
void write_image(const std::filesystem::path& path, const Image& image,
                 const ImageMetadata& metadata, const Channels& channels = {},
                 const std::function<void()>& between_strips = {}, bool fast = false);

/// Writes a picture that will soon be replaced: without compression where `fast` has that effect,
/// with "parray:partial" in the metadata, and without waiting for the disk. Throws as write_image()
/// does.
void write_preview(const std::filesystem::path& path, const Image& image,
                   const std::function<void()>& between_strips);

/// The contents of a picture file: linear RGB (8- and 16-bit integers are decoded from sRGB and
/// premultiplied), metadata (single texts and numbers), and the other channels, sorted by name.
/// EXR: UINT as integers, HALF as floats. Other formats have only alpha_channel, unless it is 1
/// everywhere. The contents decide the format, not the name.
struct ImageFile {
  Image image;
  ImageMetadata metadata;
  Channels channels;
  bool high_dynamic_range = false;  ///< EXR, float TIFF and others: values may be outside [0, 1]
};

/// Reads a picture file. Throws InputError "FILE: reason" if the libraries cannot read the file, if
/// it has fewer than 3 channels, or if it exceeds common/scene/limits.h.
ImageFile read_image(const std::filesystem::path& path);

/// Return the versions of the loaded OpenImageIO ("none" if this ParRay lacks it), and of the
/// OpenEXR that ParRay was built with: "2.4.7". Throw RunError if the module cannot be loaded.
std::string image_library_version();
std::string exr_library_version();

}  // namespace parray::picture
