#include "common/image/image_file.h"

#include <dlfcn.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <stdexcept>
#include <system_error>

#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/image/exr_header.h"
#include "common/image/image_codec.h"
#include "common/image/partial_file.h"
#include "common/image/png_file.h"
#include "common/image/transparency.h"

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

/// Throws std::logic_error unless the file can hold the channels as they are.
void check_channels(const fs::path& path, const Image& image, const Channels& channels) {
  const std::size_t pixels = std::size_t{image.width} * image.height;
  for (const Channel& channel : channels) {
    const auto size = std::visit([](const auto& values) { return values.size(); }, channel.values);
    const bool fits = can_hold_channels(path) || channel.name == alpha_channel;
    if (size != pixels || !fits) {
      throw std::logic_error("channel " + channel.name + " does not fit the picture");
    }
  }
}

/// Where it is built and where it is installed: in bin/../lib/parray, beside the programs that are
/// there.
fs::path module_file() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) throw RunError("finding this program: " + error.message());
  const fs::path beside = program.parent_path() / "image_codec.so";
  if (fs::exists(beside, error)) return beside;
  return program.parent_path().parent_path() / "lib" / "parray" / beside.filename();
}

/// Stays loaded until the program ends.
const ImageCodec& codec() {
  static const ImageCodec& loaded = []() -> const ImageCodec& {
    const fs::path file = module_file();
    void* const module = dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    void* const entry = module == nullptr ? nullptr : dlsym(module, image_codec_entry);
    if (entry == nullptr) {
      throw RunError("loading what reads and writes pictures: " + std::string(dlerror()) +
                     ": install ParRay and OpenImageIO again");
    }
    return *reinterpret_cast<ImageCodecEntry>(entry)();
  }();
  return loaded;
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

bool can_hold_channels(const fs::path& path) { return format_of(path) == Format::exr; }

double write_seconds(const fs::path& path, const PictureSize& size, bool fast) {
  constexpr double opening = 0.01;
  const auto pixels = static_cast<double>(size.width * size.height);
  if (!can_hold_channels(path)) return opening + pixels * (fast ? 20e-9 : 90e-9);
  const double bytes = pixels * 4 * static_cast<double>(3 + size.channels);
  return opening + bytes * (fast ? 4.5e-9 : 60e-9);
}

void load_image_library() {
  try {
    codec();
  } catch (const RunError&) {
    return;  // whoever needs it meets the same
  }
}

static void write_partial(const PartialFile& file, const fs::path& path, const Image& image,
                          const ImageMetadata& metadata, const Channels& channels,
                          const std::function<void()>& between_strips, bool fast) {
  const bool exr = format_of(path) == Format::exr;
  const std::string name = file.path().string();
  const ImageMetadata kept = as_kept(metadata, exr);
  const std::string problem =
      exr ? codec().write_exr(name, image, kept, channels, between_strips, fast)
          : write_png(name, image, kept, between_strips, fast, alpha_of(channels));
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

std::string image_library_version() { return codec().version(); }

/// What opens, or seems to, and is no file.
static void check_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(path.string() + ": no such file: check the path");
  if (fs::is_directory(status)) {
    throw InputError(path.string() + ": is a directory: name a picture in it");
  }
}

ImageFile read_image(const fs::path& path) {
  try {
    check_file(path);
    check_exr_attributes(path);
    check_png_chunks(path);
    return codec().read(path.string());
  } catch (const InputError& error) {
    constexpr std::size_t longest_message = 6000;                // with a path of 4096 bytes
    throw InputError(printable(error.what(), longest_message));  // the library quotes the file
  }
}

}  // namespace parray
