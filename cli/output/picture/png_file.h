#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "cli/output/picture/image_file.h"
#include "common/image/image.h"

namespace parray::picture {

/// Writes srgb_bytes() of an image, or, with `alpha` of every pixel, transparent_bytes() of it, as
/// a PNG file with an sRGB chunk of intent 0 (perceptual), and `metadata`, which is text
/// (as_kept()), before the pixels; dpi_key among it becomes a chunk pHYs, too. `fast`: not
/// compressed. Returns empty, or why the file could not be written. `between_strips`, if set, is
/// called every few milliseconds of writing, and may throw.
std::string write_png(const std::string& file, const Image& image, const ImageMetadata& metadata,
                      const std::function<void()>& between_strips, bool fast,
                      std::span<const float> alpha = {});

/// Reads a PNG file, as read_image() has it. Throws InputError "FILE: reason". Call
/// check_png_chunks() before.
ImageFile read_png(const std::string& path);

/// Refuses a PNG file that is cut off, or that has changed since it was written (the checksum of
/// one of its chunks): the library, which would find that too, prints lines of its own. What is no
/// PNG file is left to others. Throws InputError "FILE: reason".
///
/// Format: https://www.w3.org/TR/png-3/#5Chunk-layout
void check_png_chunks(const std::filesystem::path& path);

}  // namespace parray::picture
