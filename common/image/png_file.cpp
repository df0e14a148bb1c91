#include "common/image/png_file.h"

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
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "common/base/error.h"
#include "common/image/srgb.h"
#include "common/image/transparency.h"

namespace parray {
namespace {

/// libpng's writer. A step that fails jumps back into attempt(), so steps hold nothing that would
/// have to be destroyed.
class PngWriter {
 public:
  explicit PngWriter(std::FILE* file)
      : file_(file),
        png_(png_create_write_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning)),
        info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {
    if (info_ == nullptr) problem_ = "not enough memory";
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter&) = delete;
  PngWriter& operator=(const PngWriter&) = delete;

  void write_head(const Image& image, const ImageMetadata& metadata, bool fast, bool alpha) {
    std::vector<png_text> texts(metadata.size());
    std::transform(metadata.begin(), metadata.end(), texts.begin(), text_chunk);
    constexpr double inches_a_metre = 1 / 0.0254;
    const auto pixels_a_metre = static_cast<png_uint_32>(
        std::lround(real_in(metadata, dpi_key).value_or(0) * inches_a_metre));
    attempt([&] {
      png_set_write_fn(png_, this, on_write, on_flush);
      png_set_IHDR(png_, info_, image.width, image.height, 8,
                   alpha ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                   PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
      png_set_sRGB_gAMA_and_cHRM(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
      // Of noise no string of bytes comes twice: looking for them takes five times as long and
      // saves nothing.
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

  /// Empty if all of it has reached the system, else why not.
  std::string finish() {
    attempt([&] { png_write_end(png_, nullptr); });
    if (problem_.empty() && std::fflush(file_) != 0) note_errno();
    return problem_;
  }

 private:
  template <typename Step>
  void attempt(const Step& step) {
    // NOLINTNEXTLINE(cert-err52-cpp): the library's way to report
    if (problem_.empty() && setjmp(png_jmpbuf(png_)) == 0) step();
  }

  /// Latin-1 is what plain text chunks are; ours is UTF-8.
  static png_text text_chunk(const std::pair<std::string, MetadataValue>& entry) {
    const auto& text = std::get<std::string>(entry.second);
    const bool ascii = std::all_of(text.begin(), text.end(), [](char c) { return c > 0; });
    png_text chunk{};
    chunk.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    chunk.key = const_cast<char*>(entry.first.c_str());
    chunk.text = const_cast<char*>(text.c_str());
    return chunk;
  }

  static void on_error(png_structp png, png_const_charp message) {
    auto& problem = static_cast<PngWriter*>(png_get_error_ptr(png))->problem_;
    if (problem.empty()) problem = message;
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp /*png*/, png_const_charp /*message*/) {}
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
  std::string problem_;
  png_structp png_;
  png_infop info_;
};

}  // namespace

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

void check_png_chunks(const std::filesystem::path& path) {
  constexpr std::string_view signature{"\x89PNG\r\n\x1a\n"};
  constexpr std::size_t around = 12;  // length, type and checksum
  std::ifstream in(path, std::ios::binary);
  std::array<char, signature.size()> head{};
  if (!in.read(head.data(), head.size()) ||
      std::string_view(head.data(), head.size()) != signature) {
    return;
  }
  const auto refuse = [&](const char* reason) {
    throw InputError(path.string() + ": " + reason + ": copy or render it again");
  };
  std::error_code error;
  std::uint64_t left = std::filesystem::file_size(path, error) - signature.size();
  if (error) return;  // no file whose size is known
  const auto next = [&in](std::span<unsigned char> bytes) {
    in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  };
  std::vector<unsigned char> block(std::size_t{1} << 16);
  for (;;) {
    if (left < around) refuse("a PNG file that is cut off");
    std::array<unsigned char, 8> begin{};
    next(begin);
    std::uint64_t data = png_get_uint_32(begin.data());
    if (data > left - around) refuse("a PNG file that is cut off");
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
    if (!in) refuse("a PNG file that cannot be read");
    if (png_get_uint_32(end.data()) != sum) refuse("a PNG file that is damaged");
    if (std::memcmp(begin.data() + 4, "IEND", 4) == 0) return;
  }
}

}  // namespace parray
