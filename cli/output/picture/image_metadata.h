#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "common/rooms.h"

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

}  // namespace parray::picture
