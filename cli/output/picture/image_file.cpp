#include "cli/output/picture/image_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstddef>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "cli/output/picture/codecs.h"
#include "cli/output/picture/partial_file.h"
#include "cli/output/picture/srgb.h"
#include "cli/output/picture/transparency.h"
#include "common/base/error.h"
#include "common/base/module.h"
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

/// Returns the next number. Returns 0 at the end of the file.
std::uint32_t next_number(std::ifstream& in) {
  std::array<char, sizeof(std::uint32_t)> bytes{};
  in.read(bytes.data(), bytes.size());
  return in ? std::bit_cast<std::uint32_t>(bytes) : 0;
}

void skip_text(std::ifstream& in) { in.ignore(std::numeric_limits<std::streamsize>::max(), '\0'); }

/// Skips a header: attributes (name, type, size, value) and a zero. Returns true at the end of the
/// header, false at the end of the file.
bool skip_header(std::ifstream& in, std::uint64_t file_bytes, const std::filesystem::path& path) {
  while (in.peek() > 0) {
    skip_text(in);
    skip_text(in);
    const std::uint32_t size = next_number(in);
    if (!in) return false;
    const std::uint64_t left = file_bytes - static_cast<std::uint64_t>(in.tellg());
    if (size > left) {
      throw InputError(path.string() + ": an attribute has " + std::to_string(size) +
                       " bytes, but only " + std::to_string(left) +
                       " bytes follow: check that the file is complete");
    }
    in.seekg(size, std::ios::cur);
  }
  return in.get() == 0;
}

/// Throws InputError "FILE: reason" for an EXR file with an attribute that is longer than the rest
/// of the file. OpenEXR would allocate and clear the stated size, up to 2 GiB, before it reads the
/// attribute. The library finds all other errors.
///
/// Format: https://openexr.com/en/latest/OpenEXRFileLayout.html
void check_exr_attributes(const std::filesystem::path& path) {
  constexpr std::uint32_t magic = 20000630;
  constexpr std::uint32_t many_parts =
      0x1000;  // flag: several parts, each with a header; an empty header ends them
  std::error_code error;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, error);
  std::ifstream in(path, std::ios::binary);
  if (error || next_number(in) != magic) return;
  const bool more = (next_number(in) & many_parts) != 0;
  while (skip_header(in, file_bytes, path) && more && in.peek() > 0) {
  }
}

namespace fs = std::filesystem;

/// Returns the format to write, by the file's extension.
Format format_of(const fs::path& path) {
  const std::string extension = lower_case(path.extension().string());
  if (extension == ".exr") return Format::exr;
  if (extension == ".png") return Format::png;
  if (extension == ".tif" || extension == ".tiff") return Format::tiff;
  if (extension == ".jpg" || extension == ".jpeg") return Format::jpeg;
  return extension == ".jp2" ? Format::jpeg2000 : Format::unknown;
}

/// Returns the real format of a file, by its first bytes.
Format format_in(const fs::path& path) {
  constexpr std::string_view exr{"\x76\x2f\x31\x01"};
  constexpr std::string_view png{"\x89PNG\r\n\x1a\n"};
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path.string() + ": " + std::generic_category().message(errno));
  std::array<char, png.size()> head{};
  in.read(head.data(), head.size());
  const std::string_view found(head.data(), static_cast<std::size_t>(in.gcount()));
  if (found.starts_with(exr)) return Format::exr;
  return found == png ? Format::png : Format::unknown;
}

/// Throws std::logic_error unless the file can contain the channels.
void check_channels(const fs::path& path, const Image& image, const Channels& channels) {
  const std::size_t pixels = std::size_t{image.width} * image.height;
  for (const Channel& channel : channels) {
    const auto size = std::visit([](const auto& values) { return values.size(); }, channel.values);
    const bool fits =
        can_hold_channels(path) || (channel.name == alpha_channel && can_hold_alpha(path));
    if (size != pixels || !fits) {
      throw std::logic_error("channel " + channel.name + " does not fit the picture");
    }
  }
}

/// Loads a module, which stays loaded until the program ends.
const ExrCodec& exr_codec() {
  static const ExrCodec& loaded = *reinterpret_cast<ExrCodecEntry>(
      module_entry("exr_codec.so", exr_codec_entry, "the module that reads and writes EXR pictures",
                   "install ParRay and OpenEXR again"))();
  return loaded;
}
constexpr const char* image_codec_file = "image_codec.so";
/// Returns whether this ParRay has the module. Python's wheel has none.
bool has_image_codec() {
  std::error_code error;
  return fs::exists(module_file(image_codec_file), error);
}
const ImageCodec& codec() {
  static const ImageCodec& loaded = *reinterpret_cast<ImageCodecEntry>(module_entry(
      image_codec_file, image_codec_entry, "the module that reads and writes such pictures",
      "install ParRay and OpenImageIO again"))();
  return loaded;
}

/// Key of the description of a TIFF file, which contains the metadata as a JSON map.
constexpr std::string_view description = "ImageDescription";

std::string description_of(const ImageMetadata& metadata) {
  nlohmann::json texts = nlohmann::json::object();
  for (const auto& [name, value] : metadata) texts[name] = text_of(value);
  return texts.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

/// Returns the metadata in a description. Returns `found` if the description contains none.
ImageMetadata described(ImageMetadata found) {
  const auto text = text_in(found, description);
  const auto map = nlohmann::json::parse(text.value_or(""), nullptr, false);
  if (!map.is_object()) return found;
  ImageMetadata metadata;
  for (const auto& [name, value] : map.items()) {
    if (value.is_string()) metadata.emplace_back(name, value.get<std::string>());
  }
  return metadata;
}

std::string write_other(const std::string& file, Format format, const Image& image,
                        const ImageMetadata& metadata, std::span<const float> alpha) {
  return codec().write(file,
                       {format, image.width, image.height, !alpha.empty(),
                        alpha.empty() ? srgb_bytes(image.rgb) : transparent_bytes(image.rgb, alpha),
                        format == Format::tiff ? description_of(metadata) : std::string(),
                        real_in(metadata, dpi_key).value_or(0)});
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

void check_image_path(const fs::path& path) {
  check_output_path(path);
  if (format_of(path) == Format::unknown) {
    const std::string extension = path.extension().string();
    throw InputError(path.string() + ": " +
                     (extension.empty() ? "the name has no extension that gives the kind of image"
                                        : "unknown kind of image '" + extension + "'") +
                     ": use .exr (float, linear), or .png, .tif, .jpg or .jp2 (8 bit, sRGB)");
  }
  if (format_of(path) == Format::exr) exr_codec();
  const bool other = format_of(path) != Format::exr && format_of(path) != Format::png;
  if (other && !has_image_codec()) {
    throw InputError(path.string() +
                     ": this ParRay has no OpenImageIO, which writes such pictures: use .png or "
                     ".exr, or Python and Pillow: picture.save(\"" +
                     path.filename().string() + "\")");
  }
}

void check_image_size(const fs::path& path, std::uint64_t width, std::uint64_t height) {
  constexpr std::uint64_t least_side = 32;  // OpenImageIO writes no valid file for less
  if (format_of(path) == Format::jpeg2000 && std::min(width, height) < least_side) {
    throw InputError(path.string() + ": JPEG 2000 needs a width and a height of at least " +
                     std::to_string(least_side) + " pixels: use .png");
  }
}

bool can_hold_channels(const fs::path& path) { return format_of(path) == Format::exr; }

bool can_hold_alpha(const fs::path& path) { return format_of(path) != Format::jpeg; }

double write_seconds(const fs::path& path, const PictureSize& size, bool fast) {
  constexpr double opening = 0.01;
  constexpr double loading = 0.45;  // OpenImageIO
  const auto pixels = static_cast<double>(size.width * size.height);
  const Format format = format_of(path);
  if (format == Format::png) return opening + pixels * (fast ? 20e-9 : 70e-9);
  if (format != Format::exr) return loading + pixels * 150e-9;
  const double bytes = pixels * 4 * static_cast<double>(3 + size.channels);
  return opening + bytes * (fast ? 4.5e-9 : 35e-9);
}

static void write_partial(const PartialFile& file, const fs::path& path, const Image& image,
                          const ImageMetadata& metadata, const Channels& channels,
                          const std::function<void()>& between_strips, bool fast) {
  check_image_size(path, image.width, image.height);
  const Format format = format_of(path);
  const std::string name = file.path().string();
  const ImageMetadata kept = as_kept(metadata, format == Format::exr);
  const std::span<const float> alpha = alpha_of(channels);
  const std::string problem =
      format == Format::exr   ? exr_codec().write(name, image, kept, channels, between_strips, fast)
      : format == Format::png ? write_png(name, image, kept, between_strips, fast, alpha)
                              : write_other(name, format, image, metadata, alpha);
  if (!problem.empty()) throw RunError("writing " + path.string() + ": " + problem);
}

void write_image(const fs::path& path, const Image& image, const ImageMetadata& metadata,
                 const Channels& channels, const std::function<void()>& between_strips, bool fast) {
  check_channels(path, image, channels);
  PartialFile file(path);
  write_partial(file, path, image, metadata, channels, between_strips, fast);
  file.commit();
}

void write_preview(const fs::path& path, const Image& image,
                   const std::function<void()>& between_strips) {
  PartialFile file(path);
  write_partial(file, path, image, {{"parray:partial", "true"}}, {}, between_strips, true);
  file.show();
}

std::string image_library_version() { return has_image_codec() ? codec().version() : "none"; }
std::string exr_library_version() { return exr_codec().version(); }

/// Throws InputError for a path that does not exist or is a directory.
static void check_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    throw InputError(path.string() + ": no such file: check the path");
  }
  if (fs::is_directory(status)) {
    throw InputError(path.string() + ": is a directory: name a picture in it");
  }
}

ImageFile read_image(const fs::path& path) {
  try {
    check_file(path);
    const Format format = format_in(path);
    if (format == Format::exr) {
      check_exr_attributes(path);
      return exr_codec().read(path.string());
    }
    if (format == Format::png) return read_png(path.string());
    if (!has_image_codec()) {
      throw InputError(path.string() +
                       ": is neither EXR nor PNG, and this ParRay has no OpenImageIO, which reads "
                       "other pictures: convert it to .png, for example with Pillow");
    }
    ImageFile file = codec().read(path.string());
    file.metadata = described(std::move(file.metadata));
    return file;
  } catch (const InputError& error) {
    constexpr std::size_t longest_message = 6000;                // with a path of 4096 bytes
    throw InputError(printable(error.what(), longest_message));  // the library quotes the file
  }
}

}  // namespace parray::picture
