#include "common/image/image_codec.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <memory>
#include <span>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/image/srgb.h"
#include "common/image/transparency.h"
#include "common/scene/limits.h"

namespace parray {
namespace {

enum class Format { exr, png, unknown };

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

void add_channels(OIIO::ImageSpec& spec, const Channels& channels) {
  if (channels.empty()) return;
  spec.channelformats.assign(3, OIIO::TypeDesc::FLOAT);
  for (const Channel& channel : channels) {
    const bool whole = std::holds_alternative<std::vector<std::uint32_t>>(channel.values);
    spec.channelnames.push_back(channel.name);
    spec.channelformats.emplace_back(whole ? OIIO::TypeDesc::UINT32 : OIIO::TypeDesc::FLOAT);
  }
  spec.nchannels += static_cast<int>(channels.size());
}

void add_attribute(OIIO::ImageSpec& spec, const std::string& name, const MetadataValue& value) {
  if (const auto* const whole = std::get_if<std::uint64_t>(&value)) {
    spec.attribute(name, static_cast<int>(*whole));
  } else if (const auto* const real = std::get_if<double>(&value)) {
    spec.attribute(name, OIIO::TypeDesc::DOUBLE, real);
  } else {
    spec.attribute(name, std::get<std::string>(value));
  }
}

OIIO::ImageSpec make_spec(const Image& image, const ImageMetadata& metadata,
                          const Channels& channels, bool fast) {
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 3,
                       OIIO::TypeDesc::FLOAT);
  spec.attribute("compression", fast ? "none" : "zip");
  spec.attribute("oiio:ColorSpace", "Linear");
  // x and y of red, green, blue and white (D65), Rec. ITU-R BT.709: sRGB's, too.
  constexpr std::array<float, 8> primaries = {0.64F, 0.33F, 0.30F,   0.60F,
                                              0.15F, 0.06F, 0.3127F, 0.3290F};
  spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, primaries.size()),
                 primaries.data());
  add_channels(spec, channels);
  for (const auto& [name, value] : metadata) {
    add_attribute(spec, name, value);
  }
  return spec;
}

/// RGB and channels of pixels [begin, end), all of a pixel side by side, as the bits of the values.
std::vector<std::uint32_t> interleaved(const Image& image, const Channels& channels,
                                       std::size_t begin, std::size_t end) {
  const std::size_t stride = 3 + channels.size();
  std::vector<std::uint32_t> words((end - begin) * stride);
  for (std::size_t i = begin; i < end; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      words[(i - begin) * stride + c] = std::bit_cast<std::uint32_t>(image.rgb[i * 3 + c]);
    }
  }
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const auto copy = [&](const auto& values) {
      for (std::size_t i = begin; i < end; ++i) {
        words[(i - begin) * stride + 3 + c] = std::bit_cast<std::uint32_t>(values[i]);
      }
    };
    std::visit(copy, channels[c].values);
  }
  return words;
}

/// Rows [begin, end) in the file's own types.
bool write_strip(OIIO::ImageOutput& out, const Image& image, const Channels& channels,
                 std::uint32_t begin, std::uint32_t end) {
  const std::size_t row = std::size_t{image.width} * 3;
  const std::span<const float> values(image.rgb.data() + begin * row, (end - begin) * row);
  const int first = static_cast<int>(begin);
  const int last = static_cast<int>(end);
  if (!channels.empty()) {
    const std::size_t width = image.width;
    const auto words = interleaved(image, channels, begin * width, end * width);
    return out.write_scanlines(first, last, 0, OIIO::TypeDesc::UNKNOWN, words.data());
  }
  return out.write_scanlines(first, last, 0, OIIO::TypeDesc::FLOAT, values.data());
}

/// A few milliseconds of compression; a multiple of EXR's zip block of 16 rows.
std::uint32_t rows_in_strip(std::uint32_t width, std::size_t channels) {
  constexpr std::size_t values = 3U << 18;
  constexpr std::size_t block = 16;
  return static_cast<std::uint32_t>(std::max(values / channels / width / block, std::size_t{1}) *
                                    block);
}

/// The file behind an ImageOutput, which remembers why a write failed: the library says only that
/// it did.
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
std::string encode(const std::string& name, CheckedFile& file, const Image& image,
                   const ImageMetadata& metadata, const Channels& channels,
                   const std::function<void()>& between_strips, bool fast) {
  const auto out = OIIO::ImageOutput::create(name);
  if (!out) return one_line(OIIO::geterror());
  if (!out->set_ioproxy(&file) || !out->open(name, make_spec(image, metadata, channels, fast))) {
    return one_line(out->geterror());
  }
  const std::uint32_t step = rows_in_strip(image.width, 3 + channels.size());
  for (std::uint32_t y = 0; y < image.height; y += step) {
    if (between_strips) between_strips();
    if (!write_strip(*out, image, channels, y, std::min(y + step, image.height))) {
      return one_line(out->geterror());
    }
  }
  return out->close() ? "" : one_line(out->geterror());
}

std::string write_exr(const std::string& name, const Image& image, const ImageMetadata& metadata,
                      const Channels& channels, const std::function<void()>& between_strips,
                      bool fast) {
  keep_library_single_threaded();
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(name.c_str(), "wbe"),
                                                               std::fclose);
  if (!stream) return std::generic_category().message(errno);
  CheckedFile file(stream.get());
  const std::string problem = encode(name, file, image, metadata, channels, between_strips, fast);
  const std::string cause = file.finish();
  return cause.empty() ? problem : cause;
}

/// What a file really is, whatever its name, by its first bytes. The library would try its readers
/// of all other kinds of file as well.
Format format_of(const std::string& path) {
  constexpr std::string_view exr{"\x76\x2f\x31\x01"};
  constexpr std::string_view png{"\x89PNG\r\n\x1a\n"};
  errno = 0;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path + ": " + std::generic_category().message(errno));
  std::array<char, png.size()> head{};
  in.read(head.data(), head.size());
  const std::string_view found(head.data(), static_cast<std::size_t>(in.gcount()));
  if (found.starts_with(exr)) return Format::exr;
  return found == png ? Format::png : Format::unknown;
}

/// Places of R, G and B among the channels; negative where there is none.
std::array<int, 3> rgb_of(const OIIO::ImageSpec& spec) {
  return {spec.channelindex("R"), spec.channelindex("G"), spec.channelindex("B")};
}

void check_readable(const std::string& path, const OIIO::ImageSpec& spec) {
  constexpr int most_channels = 256;
  // Of all channels: what a small file can make us take. The largest picture of ours has 64 a
  // pixel.
  constexpr std::uint64_t most_bytes = limits::max_pixels * 64;
  const auto refuse = [&](const std::string& reason) { throw InputError(path + ": " + reason); };
  const auto rgb = rgb_of(spec);
  if (*std::min_element(rgb.begin(), rgb.end()) < 0 || spec.width < 1 || spec.height < 1) {
    refuse("not an RGB image");
  }
  if (spec.nchannels > most_channels) refuse("more than 256 channels");
  const auto width = static_cast<std::uint64_t>(spec.width);
  const auto height = static_cast<std::uint64_t>(spec.height);
  if (std::max(width, height) > limits::max_image_side || width * height > limits::max_pixels) {
    refuse(std::to_string(width) + " x " + std::to_string(height) + " pixels; at most " +
           std::to_string(limits::max_image_side) + " a side and " +
           std::to_string(limits::max_pixels) + " in all");
  }
  if (spec.image_bytes(true) > most_bytes) {
    refuse(std::to_string(spec.nchannels) + " channels are more than " +
           std::to_string(most_bytes) + " bytes: remove some");
  }
}

/// Of a PNG file's red, green, blue, alpha.
void apply_alpha(const std::uint8_t* bytes, ImageFile& file) {
  std::vector<float> alpha(std::size_t{file.image.width} * file.image.height);
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    alpha[i] = static_cast<float>(bytes[4 * i + 3]) / 255;
    for (std::size_t c = 0; c < 3; ++c) file.image.rgb[3 * i + c] *= alpha[i];
  }
  const auto covers = [](float value) { return value == 1; };
  if (!std::all_of(alpha.begin(), alpha.end(), covers)) {
    file.channels.push_back({alpha_channel, std::move(alpha)});
  }
}

/// False: the library says why. Colours become premultiplied, and alpha a channel, unless it is 1
/// everywhere.
bool read_png(OIIO::ImageInput& in, ImageFile& file) {
  const std::size_t pixels = std::size_t{file.image.width} * file.image.height;
  const int channels = in.spec().alpha_channel == 3 ? 4 : 3;
  const std::size_t stride = static_cast<std::size_t>(channels);
  // Untouched until there is something to put in, here and below.
  const auto bytes = std::make_unique_for_overwrite<std::uint8_t[]>(pixels * stride);
  if (!in.read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, bytes.get())) return false;
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = static_cast<float>(srgb_decode(static_cast<double>(i) / 255));
  }
  file.image.rgb.resize(pixels * 3);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      file.image.rgb[3 * i + c] = linear[bytes[stride * i + c]];
    }
  }
  if (channels == 4) apply_alpha(bytes.get(), file);
  return true;
}

/// A file's pixels as they lie there: the values of a pixel side by side, each in its own type.
struct NativePixels {
  const OIIO::ImageSpec& spec;
  std::unique_ptr<std::byte[]> bytes;

  /// Channel `index` as values of type `T`, to every `stride`-th of `to`.
  template <typename T>
  void copy(int index, T* to, std::size_t stride = 1) const {
    std::size_t offset = 0;
    for (int before = 0; before < index; ++before) {
      offset += spec.channel_bytes(before, true);
    }
    OIIO::convert_image(
        1, spec.width, spec.height, 1, bytes.get() + offset, spec.channelformat(index),
        static_cast<OIIO::stride_t>(spec.pixel_bytes(true)), OIIO::AutoStride, OIIO::AutoStride, to,
        OIIO::TypeDescFromC<T>::value(), static_cast<OIIO::stride_t>(stride * sizeof(T)),
        OIIO::AutoStride, OIIO::AutoStride);
  }
};

/// False: the library says why.
bool read_exr(OIIO::ImageInput& in, const std::array<int, 3>& rgb, ImageFile& file) {
  const OIIO::ImageSpec& spec = in.spec();
  const NativePixels pixels{spec,
                            std::make_unique_for_overwrite<std::byte[]>(spec.image_bytes(true))};
  if (!in.read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UNKNOWN, pixels.bytes.get())) {
    return false;
  }
  const std::size_t count = std::size_t{file.image.width} * file.image.height;
  file.image.rgb.resize(count * 3);
  for (std::size_t c = 0; c < 3; ++c) {
    pixels.copy(rgb[c], file.image.rgb.data() + c, 3);
  }
  for (int index = 0; index < spec.nchannels; ++index) {
    if (std::find(rgb.begin(), rgb.end(), index) != rgb.end()) continue;
    Channel channel{spec.channel_name(index).c_str(), {}};
    if (spec.channelformat(index) == OIIO::TypeDesc::UINT32) {
      channel.values = std::vector<std::uint32_t>(count);
    } else {
      channel.values = std::vector<float>(count);
    }
    std::visit([&](auto& values) { pixels.copy(index, values.data()); }, channel.values);
    file.channels.push_back(std::move(channel));
  }
  std::sort(file.channels.begin(), file.channels.end(),
            [](const Channel& a, const Channel& b) { return a.name < b.name; });
  return true;
}

/// Single text and numbers.
ImageMetadata metadata_of(const OIIO::ImageSpec& spec) {
  ImageMetadata metadata;
  for (const auto& attribute : spec.extra_attribs) {
    const std::string name = attribute.name().string();
    const OIIO::TypeDesc type = attribute.type();
    if (type == OIIO::TypeDesc::STRING) {
      metadata.emplace_back(name, attribute.get_string());
    } else if (type == OIIO::TypeDesc::INT && attribute.get_int() >= 0) {
      metadata.emplace_back(name, static_cast<std::uint64_t>(attribute.get_int()));
    } else if (type == OIIO::TypeDesc::DOUBLE) {
      metadata.emplace_back(name, attribute.get<double>());
    } else if (type == OIIO::TypeDesc::FLOAT) {
      metadata.emplace_back(name, static_cast<double>(attribute.get_float()));
    }
  }
  return metadata;
}

ImageFile read_file(const std::string& path) {
  keep_library_single_threaded();
  const Format format = format_of(path);
  if (format == Format::unknown) {
    throw InputError(path + ": neither EXR nor PNG: convert it to one of them");
  }
  const auto in = OIIO::ImageInput::create(format == Format::exr ? "openexr" : "png");
  if (!in) throw InputError(path + ": " + one_line(OIIO::geterror()));
  OIIO::ImageSpec spec;
  OIIO::ImageSpec hints;
  hints.attribute("oiio:UnassociatedAlpha", 1);  // as it is written, not rounded once more
  if (!in->open(path, spec, hints)) throw InputError(path + ": " + one_line(in->geterror()));
  check_readable(path, spec);
  ImageFile file;
  file.high_dynamic_range = format == Format::exr;
  file.image.width = static_cast<std::uint32_t>(spec.width);
  file.image.height = static_cast<std::uint32_t>(spec.height);
  if (!(format == Format::png ? read_png(*in, file) : read_exr(*in, rgb_of(spec), file))) {
    throw InputError(path + ": " + one_line(in->geterror()));
  }
  file.metadata = metadata_of(spec);
  return file;
}

std::string library_version() {
  const int version = OIIO::openimageio_version();
  return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
         std::to_string(version % 100);
}

}  // namespace

extern "C" [[gnu::visibility("default")]] const ImageCodec* parray_image_codec() {
  static const ImageCodec codec{write_exr, read_file, library_version};
  return &codec;
}

}  // namespace parray
