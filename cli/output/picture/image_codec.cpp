#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <utility>

#include "cli/output/picture/codecs.h"
#include "cli/output/picture/srgb.h"
#include "cli/output/picture/transparency.h"
#include "common/base/error.h"

namespace parray::picture {
namespace {

/// Pictures are written by small clients, or while all cores are busy. A thread pool would only add
/// cost.
void keep_library_single_threaded() { OIIO::attribute("threads", 1); }

/// Joins the lines of a library's message, because ParRay's messages have one line.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) {
    text.pop_back();
  }
  std::ranges::replace(text, '\n', ' ');
  return text.empty() ? "unknown error" : text;
}

OIIO::ImageSpec spec_of(const OtherPicture& picture) {
  OIIO::ImageSpec spec(static_cast<int>(picture.width), static_cast<int>(picture.height),
                       picture.alpha ? 4 : 3, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  if (picture.alpha) spec.attribute("oiio:UnassociatedAlpha", 1);
  if (picture.dpi > 0) {
    spec.attribute("XResolution", static_cast<float>(picture.dpi));
    spec.attribute("YResolution", static_cast<float>(picture.dpi));
    spec.attribute("ResolutionUnit", "in");
  }
  if (picture.format == Format::jpeg) {
    spec.attribute("Compression", "jpeg:95");
    spec.attribute("jpeg:subsampling", "4:4:4");
  }
  if (picture.format == Format::tiff) spec.attribute("Compression", "zip");
  if (!picture.description.empty()) spec.attribute("ImageDescription", picture.description);
  return spec;
}

std::string write(const std::string& name, const OtherPicture& picture) {
  keep_library_single_threaded();
  const auto out = OIIO::ImageOutput::create(picture.format == Format::tiff   ? "tiff"
                                             : picture.format == Format::jpeg ? "jpeg"
                                                                              : "jpeg2000");
  if (!out) return one_line(OIIO::geterror());
  if (!out->open(name, spec_of(picture)) ||
      !out->write_image(OIIO::TypeDesc::UINT8, picture.bytes.data()) || !out->close()) {
    return one_line(out->geterror());
  }
  return "";
}

/// Undoes the sRGB curve of colours. The values are whole numbers up to `most`, which the library
/// has divided by `most`. The results equal those of a PNG file.
void undo_curve(std::vector<float>& values, std::size_t channels, double most) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double fraction = std::round(values[i] * most) / most;
    values[i] = static_cast<float>(i % channels < 3 ? srgb_decode(fraction) : fraction);
  }
}

void take_pixels(const std::vector<float>& values, std::size_t channels, bool curved,
                 ImageFile& file) {
  const std::size_t pixels = values.size() / channels;
  std::vector<float> alpha(channels == 4 ? pixels : 0);
  file.image.rgb.resize(3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    if (channels == 4) alpha[i] = values[4 * i + 3];
    const float covered = channels == 4 && curved ? alpha[i] : 1;
    for (std::size_t c = 0; c < 3; ++c) {
      file.image.rgb[3 * i + c] = covered * values[channels * i + c];
    }
  }
  const auto covers = [](float value) { return value == 1; };
  if (!std::ranges::all_of(alpha, covers)) {
    file.channels.push_back({alpha_channel, std::move(alpha)});
  }
}

/// Returns the single texts and numbers in the file.
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

ImageFile read(const std::string& path) {
  keep_library_single_threaded();
  OIIO::ImageSpec hints;
  hints.attribute("oiio:UnassociatedAlpha", 1);  // values as stored, without another rounding
  const auto in = OIIO::ImageInput::open(path, &hints);
  if (!in) {
    const std::string why = one_line(OIIO::geterror());
    const bool unknown = why.find("could not find a format reader") != std::string::npos;
    throw InputError(
        path + (unknown ? ": not a picture in a known format: use an EXR, PNG, TIFF or JPEG file"
                        : ": the picture cannot be read: " + why));
  }
  const OIIO::ImageSpec& spec = in->spec();
  if (spec.nchannels < 3 || spec.width < 1 || spec.height < 1 || spec.depth > 1) {
    throw InputError(path +
                     ": the file is not an RGB image: name a picture with red, green and blue");
  }
  ImageFile file;
  file.image.width = static_cast<std::uint32_t>(spec.width);
  file.image.height = static_cast<std::uint32_t>(spec.height);
  const int channels = spec.alpha_channel == 3 ? 4 : 3;
  const auto stride = static_cast<std::size_t>(channels);
  check_image_limits(path, file.image.width, file.image.height, stride);
  file.high_dynamic_range = spec.format.is_floating_point();
  std::vector<float> values(stride * file.image.width * file.image.height);
  if (!in->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, values.data())) {
    throw InputError(path + ": " + one_line(in->geterror()));
  }
  if (!file.high_dynamic_range) undo_curve(values, stride, spec.format.size() == 1 ? 255 : 65535);
  take_pixels(values, stride, !file.high_dynamic_range, file);
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
  static const ImageCodec codec{write, read, library_version};
  return &codec;
}

}  // namespace parray::picture
