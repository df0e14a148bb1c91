#include "cli/output/picture/image_metadata.h"

#include <limits>

#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::picture {
namespace {

/// Largest range of integers in which a double represents each one.
constexpr std::uint64_t most_exact = std::uint64_t{1} << 53;

MetadataValue kept_in_exr(const MetadataValue& value) {
  const auto* const whole = std::get_if<std::uint64_t>(&value);
  if (whole == nullptr || *whole <= std::numeric_limits<std::int32_t>::max()) return value;
  if (*whole <= most_exact) return static_cast<double>(*whole);
  return text_of(value);
}

const MetadataValue* value_in(const ImageMetadata& metadata, std::string_view name) {
  for (const auto& [key, value] : metadata) {
    if (key == name) return &value;
  }
  return nullptr;
}

}  // namespace

std::string text_of(const MetadataValue& value) {
  if (const auto* const whole = std::get_if<std::uint64_t>(&value)) return std::to_string(*whole);
  if (const auto* const real = std::get_if<double>(&value)) return number_text(*real);
  return std::get<std::string>(value);
}

ImageMetadata as_kept(const ImageMetadata& metadata, bool exr) {
  ImageMetadata kept;
  for (const auto& [name, value] : metadata) {
    kept.emplace_back(name, exr ? kept_in_exr(value) : MetadataValue(text_of(value)));
  }
  return kept;
}

std::optional<std::string> text_in(const ImageMetadata& metadata, std::string_view name) {
  const MetadataValue* const value = value_in(metadata, name);
  const auto* const text = value == nullptr ? nullptr : std::get_if<std::string>(value);
  return text == nullptr ? std::nullopt : std::optional(*text);
}

std::optional<std::uint64_t> whole_in(const ImageMetadata& metadata, std::string_view name) {
  const MetadataValue* const value = value_in(metadata, name);
  if (value == nullptr) return std::nullopt;
  if (const auto* const whole = std::get_if<std::uint64_t>(value)) return *whole;
  if (const auto* const text = std::get_if<std::string>(value)) return parsed<std::uint64_t>(*text);
  const double real = std::get<double>(*value);
  const bool exact = real >= 0 && real <= static_cast<double>(most_exact);
  const auto whole = static_cast<std::uint64_t>(exact ? real : 0);
  return exact && static_cast<double>(whole) == real ? std::optional(whole) : std::nullopt;
}

std::optional<double> real_in(const ImageMetadata& metadata, std::string_view name) {
  const MetadataValue* const value = value_in(metadata, name);
  if (value == nullptr) return std::nullopt;
  if (const auto* const text = std::get_if<std::string>(value)) return parsed<double>(*text);
  if (const auto* const whole = std::get_if<std::uint64_t>(value)) {
    return static_cast<double>(*whole);
  }
  return std::get<double>(*value);
}

}  // namespace parray::picture
