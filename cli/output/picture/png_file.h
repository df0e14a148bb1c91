#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "cli/output/picture/image_file.h"
#include "common/image/image.h"

namespace parray::picture {

/// Writes a PNG file of srgb_bytes(), or of transparent_bytes() with `alpha`, which has a value for
/// every pixel. Adds an sRGB chunk of intent 0 (perceptual) and `metadata` (text, as_kept()) before
/// the pixels; dpi_key also becomes a pHYs chunk. `fast`: no compression. Returns an empty text, or
/// why writing failed. Calls `between_strips`, if set, every few milliseconds of writing; it may
/// throw.
std::string write_png(const std::string& file, const Image& image, const ImageMetadata& metadata,
                      const std::function<void()>& between_strips, bool fast,
                      std::span<const float> alpha = {});

/// Reads a PNG file, as read_image() does. Call check_png_chunks() before. Throws InputError "FILE:
/// reason".
ImageFile read_png(const std::string& path);

/// Throws InputError "FILE: reason" for a PNG file that is truncated or has a chunk with a wrong
/// checksum. The library would find such errors too, but prints lines of its own. Accepts all other
/// files.
///
/// Format: https://www.w3.org/TR/png-3/#5Chunk-layout
void check_png_chunks(const std::filesystem::path& path);

}  // namespace parray::picture
