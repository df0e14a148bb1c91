#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csetjmp>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "cli/output/picture/codecs.h"
#include "cli/output/picture/srgb.h"
#include "cli/output/picture/transparency.h"
#include "common/base/error.h"

namespace parray::picture {
namespace {

/// Calls libpng. A step that fails jumps back into attempt(). Therefore steps must not have objects
/// with destructors.
class PngSteps {
 protected:
  /// `create`: png_create_write_struct() or png_create_read_struct().
  explicit PngSteps(decltype(png_create_read_struct)& create)
      : png_(create(PNG_LIBPNG_VER_STRING, this, on_error, on_warning)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {
    if (info_ == nullptr) problem_ = "not enough memory";
  }

  void attempt(const auto& step) {
    // NOLINTNEXTLINE(cert-err52-cpp): the library's way to report
    if (problem_.empty() && setjmp(png_jmpbuf(png_)) == 0) step();
  }

  std::string problem_;
  png_structp png_;
  png_infop info_;

 private:
  static void on_error(png_structp png, png_const_charp message) {
    auto& problem = static_cast<PngSteps*>(png_get_error_ptr(png))->problem_;
    if (problem.empty()) problem = message;
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}
};

class PngWriter : PngSteps {
 public:
  explicit PngWriter(std::FILE* file) : PngSteps(png_create_write_struct), file_(file) {}
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter& operator=(PngWriter&&) = delete;

  void write_head(const Image& image, const ImageMetadata& metadata, bool fast, bool alpha) {
    std::vector<png_text> texts(metadata.size());
    std::ranges::transform(metadata, texts.begin(), text_chunk);
    constexpr double inches_a_metre = 1 / 0.0254;
    const auto pixels_a_metre = static_cast<png_uint_32>(
        std::lround(real_in(metadata, dpi_key).value_or(0) * inches_a_metre));
    attempt([&] {
      png_set_write_fn(png_, this, on_write, on_flush);
      png_set_IHDR(png_, info_, image.width, image.height, 8,
                   alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                   PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
      png_set_sRGB_gAMA_and_cHRM(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
      // In noise, byte sequences do not repeat. Searching for repetitions would take five times as
      // long and save nothing.
      png_set_compression_level(png_, fast ? Z_NO_COMPRESSION : Z_BEST_SPEED);
      png_set_compression_strategy(png_, Z_RLE);
      png_set_compression_buffer_size(png_, std::size_t{1} << 16);
      png_set_filter(png_, PNG_FILTER_TYPE_BASE, fast ? PNG_FILTER_NONE : PNG_FILTER_PAETH);
      png_set_text(png_, info_, texts.data(), static_cast<int>(texts.size()));
      if (pixels_a_metre > 0) {
        png_set_pHYs(png_, info_, pixels_a_metre, pixels_a_metre, PNG_RESOLUTION_METER);
      }
      png_write_info(png_, info_);
    });
  }

  void write_row(const std::uint8_t* row) {
    attempt([&] { png_write_row(png_, row); });
  }

  /// Returns "" if the system has accepted all data, otherwise the reason.
  std::string finish() {
    attempt([&] { png_write_end(png_, nullptr); });
    if (problem_.empty() && std::fflush(file_) != 0) note_errno();
    return problem_;
  }

 private:
  /// Uses an international text chunk, because plain text chunks are Latin-1 and ParRay's texts are
  /// UTF-8.
  static png_text text_chunk(const std::pair<std::string, MetadataValue>& entry) {
    const auto& text = std::get<std::string>(entry.second);
    const bool ascii = std::ranges::all_of(text, [](char c) { return c > 0; });
    png_text chunk{};
    chunk.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    chunk.key = const_cast<char*>(entry.first.c_str());
    chunk.text = const_cast<char*>(text.c_str());
    return chunk;
  }

  static void on_write(png_structp png, png_bytep bytes, std::size_t size) {
    auto& writer = *static_cast<PngWriter*>(png_get_io_ptr(png));
    errno = 0;
    if (std::fwrite(bytes, 1, size, writer.file_) == size) return;
    writer.note_errno();
    png_error(png, "");
  }
  static void on_flush(png_structp /*png*/) {}

  void note_errno() { problem_ = std::generic_category().message(errno != 0 ? errno : EIO); }

  std::FILE* file_;
};

/// Reads as 8-bit RGB or RGBA, for any form of the file.
class PngReader : PngSteps {
 public:
  explicit PngReader(std::FILE* file) : PngSteps(png_create_read_struct) {
    attempt([&] {
      png_init_io(png_, file);
      png_read_info(png_, info_);
    });
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader& operator=(PngReader&&) = delete;

  [[nodiscard]] const std::string& problem() const { return problem_; }
  [[nodiscard]] std::uint32_t width() const { return png_get_image_width(png_, info_); }
  [[nodiscard]] std::uint32_t height() const { return png_get_image_height(png_, info_); }
  [[nodiscard]] bool has_colours() const {
    return (png_get_color_type(png_, info_) & PNG_COLOR_MASK_COLOR) != 0;
  }
  [[nodiscard]] bool has_alpha() const {
    return (png_get_color_type(png_, info_) & PNG_COLOR_MASK_ALPHA) != 0 ||
           png_get_valid(png_, info_, PNG_INFO_tRNS) != 0;
  }

  /// Reads three bytes per pixel, or four with alpha, top row first.
  void read(std::uint8_t* bytes) {
    const std::size_t row = std::size_t{width()} * (has_alpha() ? 4 : 3);
    const std::uint32_t rows = height();
    attempt([&] {
      png_set_expand(png_);
      png_set_scale_16(png_);
      const int passes = png_set_interlace_handling(png_);
      png_read_update_info(png_, info_);
      for (int pass = 0; pass < passes; ++pass) {
        for (std::uint32_t y = 0; y < rows; ++y) png_read_row(png_, bytes + y * row, nullptr);
      }
      png_read_end(png_, info_);
    });
  }

  [[nodiscard]] ImageMetadata metadata() const {
    png_textp texts = nullptr;
    int count = 0;
    png_get_text(png_, info_, &texts, &count);
    ImageMetadata metadata;
    for (const png_text& text : std::span(texts, static_cast<std::size_t>(count))) {
      metadata.emplace_back(text.key, std::string(text.text == nullptr ? "" : text.text));
    }
    return metadata;
  }
};

/// Premultiplies the colours of `file` by the alpha of `bytes`: red, green, blue, alpha of each
/// pixel. Keeps alpha as a channel unless it is 1 everywhere.
void apply_alpha(const std::uint8_t* bytes, ImageFile& file) {
  std::vector<float> alpha(std::size_t{file.image.width} * file.image.height);
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    alpha[i] = static_cast<float>(bytes[4 * i + 3]) / 255;
    for (std::size_t c = 0; c < 3; ++c) file.image.rgb[3 * i + c] *= alpha[i];
  }
  const auto covers = [](float value) { return value == 1; };
  if (!std::ranges::all_of(alpha, covers)) {
    file.channels.push_back({alpha_channel, std::move(alpha)});
  }
}

/// Sets the colours of `image` from sRGB bytes; each pixel has `stride` bytes, colours first.
void set_linear(const std::uint8_t* bytes, std::size_t stride, Image& image) {
  std::array<float, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = static_cast<float>(srgb_decode(static_cast<double>(i) / 255));
  }
  const std::size_t pixels = std::size_t{image.width} * image.height;
  image.rgb.resize(pixels * 3);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) image.rgb[3 * i + c] = linear[bytes[stride * i + c]];
  }
}

/// Throws InputError "FILE: reason" for a PNG file that is truncated or has a chunk with a wrong
/// checksum. The library would find such errors too, but prints lines of its own.
///
/// Format: https://www.w3.org/TR/png-3/#5Chunk-layout
void check_chunks(const std::string& path) {
  constexpr std::size_t signature = 8;
  constexpr std::size_t around = 12;  // length, type and checksum
  std::ifstream in(path, std::ios::binary);
  in.seekg(signature);
  const auto refuse = [&](const char* reason) {
    throw InputError(path + ": " + reason + ": copy or render it again");
  };
  std::error_code error;
  std::uint64_t left = std::filesystem::file_size(path, error) - signature;
  if (error) return;  // the size of the file is unknown
  const auto next = [&in](std::span<unsigned char> bytes) {
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  std::vector<unsigned char> block(std::size_t{1} << 16);
  for (;;) {
    if (left < around) refuse("the PNG file is truncated");
    std::array<unsigned char, 8> begin{};
    next(begin);
    std::uint64_t data = png_get_uint_32(begin.data());
    if (data > left - around) refuse("the PNG file is truncated");
    left -= data + around;
    uLong sum = crc32(0, begin.data() + 4, 4);
    while (data > 0) {
      const auto part = std::span(block).first(std::min<std::uint64_t>(data, block.size()));
      next(part);
      sum = crc32(sum, part.data(), static_cast<uInt>(part.size()));
      data -= part.size();
    }
    std::array<unsigned char, 4> end{};
    next(end);
    if (!in) refuse("the PNG file cannot be read");
    if (png_get_uint_32(end.data()) != sum) refuse("the PNG file is damaged");
    if (std::memcmp(begin.data() + 4, "IEND", 4) == 0) return;
  }
}

}  // namespace

ImageFile read_png(const std::string& path) {
  check_chunks(path);
  const auto refuse = [&](const std::string& reason) { throw InputError(path + ": " + reason); };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(path.c_str(), "rbe"),
                                                               std::fclose);
  if (!stream) refuse(std::generic_category().message(errno));
  PngReader reader(stream.get());
  if (!reader.problem().empty()) refuse("the PNG file is damaged: " + reader.problem());
  if (!reader.has_colours()) {
    refuse("the file is not an RGB image: name a picture with red, green and blue");
  }
  const std::size_t stride = reader.has_alpha() ? 4 : 3;
  check_image_limits(path, reader.width(), reader.height(), stride);
  ImageFile file;
  file.image.width = reader.width();
  file.image.height = reader.height();
  // Memory stays untouched until data arrive.
  const auto bytes = std::make_unique_for_overwrite<std::uint8_t[]>(std::size_t{reader.width()} *
                                                                    reader.height() * stride);
  reader.read(bytes.get());
  if (!reader.problem().empty()) refuse("the PNG file is damaged: " + reader.problem());
  set_linear(bytes.get(), stride, file.image);
  if (stride == 4) apply_alpha(bytes.get(), file);
  file.metadata = reader.metadata();
  return file;
}

std::string write_png(const std::string& file, const Image& image, const ImageMetadata& metadata,
                      const std::function<void()>& between_strips, bool fast,
                      std::span<const float> alpha) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.c_str(), "wbe"),
                                                               std::fclose);
  if (!stream) return std::generic_category().message(errno);
  PngWriter writer(stream.get());
  writer.write_head(image, metadata, fast, !alpha.empty());
  const std::size_t width = image.width;
  const std::size_t row = width * 3;
  const std::size_t strip = std::max<std::size_t>((std::size_t{1} << 17) / row, 1);
  for (std::size_t y = 0; y < image.height; y += strip) {
    if (between_strips) between_strips();
    const std::size_t rows = std::min<std::size_t>(strip, image.height - y);
    const auto rgb = std::span(image.rgb).subspan(y * row, rows * row);
    const auto bytes = alpha.empty()
                           ? srgb_bytes(rgb)
                           : transparent_bytes(rgb, alpha.subspan(y * width, rows * width));
    for (std::size_t i = 0; i < rows; ++i) {
      writer.write_row(bytes.data() + i * (bytes.size() / rows));
    }
  }
  return writer.finish();
}

}  // namespace parray::picture
