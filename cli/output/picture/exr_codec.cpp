#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/OpenEXRConfig.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>
#include <variant>
#include <vector>

#include "cli/output/picture/codecs.h"
#include "common/base/error.h"

namespace parray::picture {
namespace {

constexpr std::array<const char*, 3> rgb_names = {"R", "G", "B"};

/// The calling thread writes the picture. A thread pool would only add cost.
constexpr int no_threads = 0;

// ---- Writing ---------------------------------------------------------------------------------

/// A stream that reports errors with the reason of the system.
class CheckedStream final : public Imf::OStream {
 public:
  CheckedStream(std::FILE* file, const std::string& name) : OStream(name.c_str()), file_(file) {}

  void write(const char bytes[], int size) override {
    errno = 0;
    if (std::fwrite(bytes, 1, static_cast<std::size_t>(size), file_) !=
        static_cast<std::size_t>(size)) {
      throw failure();
    }
  }
  std::uint64_t tellp() override { return static_cast<std::uint64_t>(std::ftell(file_)); }
  void seekp(std::uint64_t position) override {
    if (std::fseek(file_, static_cast<long>(position), SEEK_SET) != 0) throw failure();
  }
  void flush() {
    errno = 0;
    if (std::fflush(file_) != 0) throw failure();
  }

 private:
  static std::system_error failure() { return {errno != 0 ? errno : EIO, std::generic_category()}; }

  std::FILE* file_;
};

void add_attribute(Imf::Header& header, const std::string& name, const MetadataValue& value) {
  if (const auto* const whole = std::get_if<std::uint64_t>(&value)) {
    header.insert(name, Imf::IntAttribute(static_cast<int>(*whole)));
  } else if (const auto* const real = std::get_if<double>(&value)) {
    header.insert(name, Imf::DoubleAttribute(*real));
  } else {
    header.insert(name, Imf::StringAttribute(std::get<std::string>(value)));
  }
}

Imf::Header header_of(const Image& image, const ImageMetadata& metadata, const Channels& channels,
                      bool fast) {
  Imf::Header header(static_cast<int>(image.width), static_cast<int>(image.height));
  header.compression() = fast ? Imf::NO_COMPRESSION : Imf::ZIP_COMPRESSION;
  // x and y of red, green, blue and white (D65), Rec. ITU-R BT.709; sRGB has the same.
  Imf::addChromaticities(header,
                         {{0.64F, 0.33F}, {0.30F, 0.60F}, {0.15F, 0.06F}, {0.3127F, 0.3290F}});
  for (const char* name : rgb_names) header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  for (const Channel& channel : channels) {
    const bool whole = std::holds_alternative<std::vector<std::uint32_t>>(channel.values);
    header.channels().insert(channel.name, Imf::Channel(whole ? Imf::UINT : Imf::FLOAT));
  }
  for (const auto& [name, value] : metadata) add_attribute(header, name, value);
  return header;
}

/// Describes where the library finds or stores values that are `stride` values apart. `values`
/// points to the value of pixel `origin`.
template <typename Value>
Imf::Slice slice_of(const Value* values, std::size_t width, std::size_t stride,
                    const Imath::V2i& origin = {0, 0}) {
  static_assert(sizeof(Value) == 4);
  // OpenEXR writes through the pointer only when it reads a file.
  return Imf::Slice::Make(std::is_same_v<Value, float> ? Imf::FLOAT : Imf::UINT, values, origin,
                          static_cast<std::int64_t>(width), 1, stride * sizeof(Value),
                          width * stride * sizeof(Value));
}

Imf::FrameBuffer frame_of(const Image& image, const Channels& channels,
                          const Imath::V2i& origin = {0, 0}) {
  Imf::FrameBuffer frame;
  for (std::size_t c = 0; c < rgb_names.size(); ++c) {
    frame.insert(rgb_names[c], slice_of(image.rgb.data() + c, image.width, 3, origin));
  }
  for (const Channel& channel : channels) {
    const auto insert = [&](const auto& values) {
      frame.insert(channel.name, slice_of(values.data(), image.width, 1, origin));
    };
    std::visit(insert, channel.values);
  }
  return frame;
}

/// Returns a number of rows that takes a few milliseconds to compress. It is a multiple of zip's
/// block of 16 rows.
int rows_in_strip(std::size_t width, std::size_t channels) {
  constexpr std::size_t values = 3U << 18;
  constexpr std::size_t block = 16;
  return static_cast<int>(std::max(values / channels / width / block, std::size_t{1}) * block);
}

std::string write(const std::string& name, const Image& image, const ImageMetadata& metadata,
                  const Channels& channels, const std::function<void()>& between_strips,
                  bool fast) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(name.c_str(), "wbe"),
                                                             std::fclose);
  if (!file) return std::generic_category().message(errno);
  CheckedStream stream(file.get(), name);
  try {
    {
      Imf::OutputFile out(stream, header_of(image, metadata, channels, fast), no_threads);
      out.setFrameBuffer(frame_of(image, channels));
      const int height = static_cast<int>(image.height);
      const int step = rows_in_strip(image.width, 3 + channels.size());
      for (int y = 0; y < height; y += step) {
        if (between_strips) between_strips();
        out.writePixels(std::min(step, height - y));
      }
    }
    stream.flush();
  } catch (const std::system_error& error) {
    return error.code().message();
  } catch (const Iex::BaseExc& error) {
    return errno != 0 ? std::generic_category().message(errno) : error.what();
  }
  return "";
}

// ---- Reading ---------------------------------------------------------------------------------

/// Returns OpenEXR's reason without its first sentence, which repeats the file's name.
std::string reason_of(const std::exception& error) {
  std::string text = error.what();
  if (const std::size_t name_end = text.find("\". "); name_end != std::string::npos) {
    text.erase(0, name_end + 3);
  }
  std::ranges::replace(text, '\n', ' ');
  while (text.ends_with('.') || text.ends_with(' ')) text.pop_back();
  return text.empty() ? "no reason given" : text;
}

/// The size of the first part's picture, and the coordinates of its first pixel.
struct Area {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  Imath::V2i origin;
};

Area area_of(const Imf::Header& header) {
  const Imath::Box2i& window = header.dataWindow();
  const auto side = [](int low, int high) {
    return static_cast<std::uint64_t>(std::int64_t{high} - low + 1);
  };
  return {side(window.min.x, window.max.x), side(window.min.y, window.max.y), window.min};
}

void check_readable(const std::string& path, const Imf::Header& header, const Area& area) {
  std::size_t channels = 0;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    ++channels;
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
      throw InputError(path + ": channel " + it.name() + " has fewer values than the picture has " +
                       "pixels: save the channel in full resolution");
    }
  }
  const bool rgb = std::ranges::all_of(
      rgb_names, [&](const char* name) { return header.channels().findChannel(name) != nullptr; });
  if (!rgb || (header.hasType() && Imf::isDeepData(header.type()))) {
    throw InputError(path +
                     ": the file is not an RGB image: name a picture with red, green and blue");
  }
  check_image_limits(path, area.width, area.height, channels);
}

/// Allocates the channels other than R, G and B, in the order of the file, which is by name.
Channels empty_channels(const Imf::Header& header, std::size_t pixels) {
  Channels channels;
  for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
    if (std::ranges::find(rgb_names, std::string_view(it.name())) != rgb_names.end()) continue;
    Channel channel{it.name(), std::vector<float>()};
    if (it.channel().type == Imf::UINT) channel.values = std::vector<std::uint32_t>();
    std::visit([&](auto& values) { values.resize(pixels); }, channel.values);
    channels.push_back(std::move(channel));
  }
  return channels;
}

/// Returns the single texts and numbers in the header.
ImageMetadata metadata_of(const Imf::Header& header) {
  ImageMetadata metadata;
  for (auto it = header.begin(); it != header.end(); ++it) {
    const Imf::Attribute& attribute = it.attribute();
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute)) {
      metadata.emplace_back(it.name(), text->value());
    } else if (const auto* whole = dynamic_cast<const Imf::IntAttribute*>(&attribute)) {
      if (whole->value() < 0) continue;
      metadata.emplace_back(it.name(), static_cast<std::uint64_t>(whole->value()));
    } else if (const auto* real = dynamic_cast<const Imf::DoubleAttribute*>(&attribute)) {
      metadata.emplace_back(it.name(), real->value());
    } else if (const auto* single = dynamic_cast<const Imf::FloatAttribute*>(&attribute)) {
      metadata.emplace_back(it.name(), static_cast<double>(single->value()));
    }
  }
  return metadata;
}

ImageFile read_parts(const std::string& path) {
  Imf::MultiPartInputFile in(path.c_str(), no_threads, false);
  const Imf::Header& header = in.header(0);
  const Area area = area_of(header);
  check_readable(path, header, area);
  ImageFile file;
  file.high_dynamic_range = true;
  file.image.width = static_cast<std::uint32_t>(area.width);
  file.image.height = static_cast<std::uint32_t>(area.height);
  file.image.rgb.resize(area.width * area.height * 3);
  file.channels = empty_channels(header, area.width * area.height);
  Imf::InputPart part(in, 0);
  part.setFrameBuffer(frame_of(file.image, file.channels, area.origin));
  part.readPixels(header.dataWindow().min.y, header.dataWindow().max.y);
  file.metadata = metadata_of(header);
  return file;
}

ImageFile read(const std::string& path) {
  try {
    return read_parts(path);
  } catch (const Iex::BaseExc& error) {
    throw InputError(path + ": the EXR file is truncated or damaged: " + reason_of(error));
  }
}

std::string version() { return OPENEXR_VERSION_STRING; }

}  // namespace

extern "C" [[gnu::visibility("default")]] const ExrCodec* parray_exr_codec() {
  static const ExrCodec codec{write, read, version};
  return &codec;
}

}  // namespace parray::picture
