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

/// Text, a whole number, or a real one.
using MetadataValue = std::variant<std::string, std::uint64_t, double>;

/// Names and values that are kept inside an image file, in order.
/// Names: letters, digits, '_' and ':', at most 79 bytes (PNG's bound).
using ImageMetadata = std::vector<std::pair<std::string, MetadataValue>>;

/// Pixels an inch when the picture is printed, a real number > 0.
inline constexpr const char* dpi_key = "parray:dpi";

/// The value as text; of a number its shortest decimal form that reads back as the same.
std::string text_of(const MetadataValue& value);

/// The values as a file can keep them. EXR: a whole number as its type `int`, from 2^31 on as
/// `double`, from 2^53 on as text; a real one as `double`. PNG knows text alone.
ImageMetadata as_kept(const ImageMetadata& metadata, bool exr);

/// What a file has kept under a name, whichever type it has become there. None: no such name, or
/// another kind of value.
std::optional<std::string> text_in(const ImageMetadata& metadata, std::string_view name);
std::optional<std::uint64_t> whole_in(const ImageMetadata& metadata, std::string_view name);
std::optional<double> real_in(const ImageMetadata& metadata, std::string_view name);

}  // namespace parray::picture
