#include "common/image/image_file.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>

#include "common/base/error.h"
#include "common/image/partial_file.h"
#include "common/image/srgb.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

namespace fs = std::filesystem;

enum class Format { exr, png, unknown };

Format format_of(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".exr") return Format::exr;
  if (extension == ".png") return Format::png;
  return Format::unknown;
}

/// Pictures are written while no core is idle, or by small clients: a pool only costs.
void keep_library_single_threaded() {
  OIIO::attribute("threads", 1);
  OIIO::attribute("exr_threads", 1);
}

/// The library's messages may have several lines; ours have one.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) {
    text.pop_back();
  }
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "unknown error" : text;
}

std::uint8_t srgb_byte(float linear) {
  if (!(linear > 0)) return 0;  // NaN too
  return static_cast<std::uint8_t>(std::lround(255 * srgb_encode(std::min(linear, 1.0F))));
}

OIIO::ImageSpec make_spec(const Image& image, Format format, const ImageMetadata& metadata) {
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 3,
                       format == Format::exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  if (format == Format::exr) {
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
  } else {
    spec.attribute("oiio:ColorSpace", "sRGB");
  }
  for (const auto& [name, value] : metadata) {
    spec.attribute(name, value);
  }
  return spec;
}

/// Rows [begin, end) in the file's own type.
bool write_strip(OIIO::ImageOutput& out, const Image& image, Format format, std::uint32_t begin,
                 std::uint32_t end) {
  const std::size_t row = std::size_t{image.width} * 3;
  const std::span<const float> values(image.rgb.data() + begin * row, (end - begin) * row);
  const int first = static_cast<int>(begin);
  const int last = static_cast<int>(end);
  if (format == Format::exr) {
    return out.write_scanlines(first, last, 0, OIIO::TypeDesc::FLOAT, values.data());
  }
  std::vector<std::uint8_t> bytes(values.size());
  std::transform(values.begin(), values.end(), bytes.begin(), srgb_byte);
  return out.write_scanlines(first, last, 0, OIIO::TypeDesc::UINT8, bytes.data());
}

/// A few milliseconds of compression; a multiple of EXR's zip block of 16 rows.
std::uint32_t rows_in_strip(std::uint32_t width) {
  constexpr std::uint32_t pixels = 1U << 18;
  constexpr std::uint32_t block = 16;
  return std::max(pixels / width / block, 1U) * block;
}

/// The file behind an ImageOutput, which remembers that a write failed: the library's PNG writer
/// would take a full disk for success.
class CheckedFile final : public OIIO::Filesystem::IOFile {
 public:
  explicit CheckedFile(std::FILE* file) : IOFile(file, Mode::Write), stream_(file) {}

  std::size_t write(const void* bytes, std::size_t size) override {
    errno = 0;
    const std::size_t written = IOFile::write(bytes, size);
    if (written != size) note_error();
    return written;
  }

  /// Empty if everything has reached the system, else why not.
  std::string finish() {
    errno = 0;
    if (std::fflush(stream_) != 0 || std::ferror(stream_) != 0) note_error();
    return error_ == 0 ? "" : std::generic_category().message(error_);
  }

 private:
  void note_error() {
    if (error_ == 0) error_ = errno != 0 ? errno : EIO;
  }

  std::FILE* stream_;
  int error_ = 0;  // the first
};

/// Empty, or what the library could not do.
std::string encode(const std::string& name, CheckedFile& file, const Image& image, Format format,
                   const ImageMetadata& metadata, const std::function<void()>& between_strips) {
  const auto out = OIIO::ImageOutput::create(name);
  if (!out) return one_line(OIIO::geterror());
  if (!out->set_ioproxy(&file) || !out->open(name, make_spec(image, format, metadata))) {
    return one_line(out->geterror());
  }
  const std::uint32_t step = rows_in_strip(image.width);
  for (std::uint32_t y = 0; y < image.height; y += step) {
    if (between_strips) between_strips();
    if (!write_strip(*out, image, format, y, std::min(y + step, image.height))) {
      return one_line(out->geterror());
    }
  }
  return out->close() ? "" : one_line(out->geterror());
}

std::string write_file(const std::string& name, const Image& image, Format format,
                       const ImageMetadata& metadata, const std::function<void()>& between_strips) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(name.c_str(), "wbe"),
                                                               std::fclose);
  if (!stream) return std::generic_category().message(errno);
  CheckedFile file(stream.get());
  const std::string problem = encode(name, file, image, format, metadata, between_strips);
  const std::string cause = file.finish();
  return cause.empty() ? problem : cause;
}

/// What a file really is, whatever its name.
Format format_of(const OIIO::ImageInput& in) {
  const std::string_view name = in.format_name();
  if (name == "openexr") return Format::exr;
  return name == "png" ? Format::png : Format::unknown;
}

void check_readable(const fs::path& path, Format format, const OIIO::ImageSpec& spec) {
  const auto refuse = [&](const std::string& reason) {
    throw InputError(path.string() + ": " + reason);
  };
  if (format == Format::unknown) refuse("neither EXR nor PNG: convert it to one of them");
  if (spec.nchannels < 3 || spec.width < 1 || spec.height < 1) refuse("not an RGB image");
  const auto width = static_cast<std::uint64_t>(spec.width);
  const auto height = static_cast<std::uint64_t>(spec.height);
  if (std::max(width, height) > limits::max_image_side || width * height > limits::max_pixels) {
    refuse(std::to_string(width) + " x " + std::to_string(height) + " pixels; at most " +
           std::to_string(limits::max_image_side) + " a side and " +
           std::to_string(limits::max_pixels) + " in all");
  }
}

std::vector<float> read_pixels(OIIO::ImageInput& in, Format format, std::size_t values) {
  std::vector<float> rgb(values);
  if (format != Format::png) {
    const bool good = in.read_image(0, 0, 0, 3, OIIO::TypeDesc::FLOAT, rgb.data());
    return good ? rgb : std::vector<float>{};
  }
  std::vector<std::uint8_t> bytes(values);
  if (!in.read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, bytes.data())) return {};
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = static_cast<float>(srgb_decode(static_cast<double>(i) / 255));
  }
  std::transform(bytes.begin(), bytes.end(), rgb.begin(),
                 [&](std::uint8_t b) { return linear[b]; });
  return rgb;
}

}  // namespace

void check_image_path(const fs::path& path) {
  check_output_path(path);
  if (format_of(path) == Format::unknown) {
    const std::string extension = path.extension().string();
    throw InputError(path.string() + ": " +
                     (extension.empty() ? "no extension says which kind of image to write"
                                        : "unknown kind of image '" + extension + "'") +
                     ": use .exr (float, linear) or .png (8 bit, sRGB)");
  }
}

void write_image(const fs::path& path, const Image& image, const ImageMetadata& metadata,
                 const std::function<void()>& between_strips) {
  keep_library_single_threaded();
  PartialFile file(path);
  const std::string problem =
      write_file(file.path().string(), image, format_of(path), metadata, between_strips);
  if (!problem.empty()) throw RunError("writing " + path.string() + ": " + problem);
  file.commit();
}

std::string image_library_version() {
  const unsigned version = OIIO::openimageio_version();
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

ImageFile read_image(const fs::path& path) {
  keep_library_single_threaded();
  const auto in = OIIO::ImageInput::open(path.string());
  if (!in) throw InputError(path.string() + ": " + one_line(OIIO::geterror()));
  const Format format = format_of(*in);
  const OIIO::ImageSpec& spec = in->spec();
  check_readable(path, format, spec);
  ImageFile file;
  file.high_dynamic_range = format == Format::exr;
  file.image.width = static_cast<std::uint32_t>(spec.width);
  file.image.height = static_cast<std::uint32_t>(spec.height);
  file.image.rgb = read_pixels(*in, format, std::size_t{file.image.width} * file.image.height * 3);
  if (file.image.rgb.empty()) throw InputError(path.string() + ": " + one_line(in->geterror()));
  for (const auto& attribute : spec.extra_attribs) {
    if (attribute.type() == OIIO::TypeDesc::STRING) {
      file.metadata.emplace_back(attribute.name().string(), attribute.get_string());
    }
  }
  return file;
}

}  // namespace parray
