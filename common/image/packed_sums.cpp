#include "common/image/packed_sums.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

#include "common/base/bytes.h"

namespace parray::image {
namespace {

constexpr std::size_t columns = 9;
constexpr std::uint8_t squares_left_out = 1;
constexpr std::uint8_t odd_left_out = 2;
constexpr std::uint8_t has_base = 128;
constexpr unsigned word_bits = 64;
constexpr std::size_t word_bytes = 8;
static_assert(sizeof(PixelSums) == columns * word_bytes, "a pixel is its columns");

/// Calls `body` with each column's number as a constant, so that the column's values stay in
/// registers.
void for_each_column(const auto& body) {
  const auto call = [&]<std::size_t... C>(std::index_sequence<C...> /*all*/) {
    (body(std::integral_constant<std::size_t, C>{}), ...);
  };
  call(std::make_index_sequence<columns>{});
}

/// Returns a column of a pixel, which may be const.
template <std::size_t C, typename Pixel>
auto& at(Pixel& pixel) {
  constexpr std::array groups = {&PixelSums::sum, &PixelSums::sum_of_squares, &PixelSums::odd};
  return (pixel.*groups[C / 3])[C % 3];
}

std::uint64_t square_from(std::uint64_t sum, std::uint64_t odd) {
  return RadianceScale::square_of(odd) + RadianceScale::square_of(sum - odd);
}

bool squares_follow(const PixelSums& pixel) {
  return pixel.sum_of_squares[0] == square_from(pixel.sum[0], pixel.odd[0]) &&
         pixel.sum_of_squares[1] == square_from(pixel.sum[1], pixel.odd[1]) &&
         pixel.sum_of_squares[2] == square_from(pixel.sum[2], pixel.odd[2]);
}

bool odd_follows(const PixelSums& pixel) {
  return pixel.odd[0] == pixel.sum[0] && pixel.odd[1] == pixel.sum[1] &&
         pixel.odd[2] == pixel.sum[2];
}

unsigned bits_of(std::uint64_t value) { return static_cast<unsigned>(std::bit_width(value)); }

/// Returns a mask of the low `width` bits, 0 .. 64.
std::uint64_t low_bits(unsigned width) {
  return width == 0 ? 0 : ~std::uint64_t{0} >> (word_bits - width);
}

/// Writes bits in whole words: up to 8 bytes beyond the last bit.
class BitWriter {
 public:
  explicit BitWriter(char* to) : to_(to) {}

  /// Appends the low `width` bits of `value`. `value` must be below 2^width, `width` in 1 .. 64.
  void put(std::uint64_t value, unsigned width) {
    word_ |= value << fill_;
    std::memcpy(to_, &word_, word_bytes);
    const bool full = fill_ + width >= word_bits;
    // Keeps the bits that did not fit. The shift has two steps, because one shift by 64 is
    // undefined.
    word_ = full ? value >> 1 >> (word_bits - 1 - fill_) : word_;
    to_ += full ? word_bytes : 0;
    fill_ = (fill_ + width) % word_bits;
  }
  /// Writes the remaining bits. Call it after the last put().
  void finish() { std::memcpy(to_, &word_, word_bytes); }

 private:
  char* to_;
  std::uint64_t word_ = 0;
  unsigned fill_ = 0;  ///< bits of word_, 0 .. 63
};

struct Column {
  unsigned width = 0;      ///< bits, 0 .. 64
  std::uint64_t base = 0;  ///< has none of the low `width` bits
  // Position of the bits in a pixel's record.
  std::size_t byte = 0;     ///< byte of the first bit
  unsigned shift = 0;       ///< place of the first bit in that byte, 0 .. 7
  bool fills_word = false;  ///< the last bit is at the end of the 8 bytes from `byte`, or beyond
  std::uint64_t mask = 0;   ///< the low `width` bits
};

/// The layout of a packed cell.
class Layout {
 public:
  Layout() = default;
  /// Chooses the layout for `pixels`. Columns that `known` leaves out are known to follow from
  /// others.
  Layout(std::span<const PixelSums> pixels, const Layout& known);
  explicit Layout(ByteReader& header);

  [[nodiscard]] std::string header() const;
  /// Returns the bytes of a pixel's record.
  [[nodiscard]] std::size_t record_bytes() const { return (record_bits_ + 7) / 8; }
  /// Returns a mask of the bits in a record's last byte that no column uses.
  [[nodiscard]] unsigned spare() const { return 0xFFU << (8 - spare_bits()) & 0xFFU; }

  void pack(const PixelSums& pixel, BitWriter& to) const;
  void unpack(const char* from, PixelSums& pixel) const;

 private:
  [[nodiscard]] bool leaves_out(std::size_t column) const {
    return (column / 3 == 1 && squares_follow_) || (column / 3 == 2 && odd_follows_);
  }
  [[nodiscard]] unsigned spare_bits() const {
    return static_cast<unsigned>(record_bytes() * 8 - record_bits_);
  }
  /// Computes the position of every column in the record.
  void place();

  bool squares_follow_ = false;
  bool odd_follows_ = false;
  std::array<Column, columns> columns_{};
  std::size_t record_bits_ = 0;
};

Layout::Layout(std::span<const PixelSums> pixels, const Layout& known)
    : squares_follow_(known.squares_follow_ || std::ranges::all_of(pixels, squares_follow)),
      odd_follows_(known.odd_follows_ || std::ranges::all_of(pixels, odd_follows)) {
  const PixelSums first = pixels.empty() ? PixelSums{} : pixels.front();
  std::array<std::uint64_t, columns> differing{};
  for (const PixelSums& pixel : pixels) {
    for_each_column([&](auto c) { differing[c] |= at<c>(pixel) ^ at<c>(first); });
  }
  for_each_column([&](auto c) {
    if (!leaves_out(c)) {
      const unsigned width = bits_of(differing[c]);
      const unsigned whole = std::max(width, bits_of(at<c>(first)));
      const bool based = pixels.size() * (whole - width) > word_bits;
      columns_[c].width = based ? width : whole;
      columns_[c].base = based ? at<c>(first) & ~low_bits(width) : 0;
    }
  });
  place();
}

Layout::Layout(ByteReader& header) {
  const auto flags = header.get<std::uint8_t>();
  squares_follow_ = (flags & squares_left_out) != 0;
  odd_follows_ = (flags & odd_left_out) != 0;
  for (std::size_t c = 0; c < columns; ++c) {
    if (!leaves_out(c)) {
      const auto width = header.get<std::uint8_t>();
      columns_[c].width = width & ~unsigned{has_base};
      columns_[c].base = (width & has_base) != 0 ? header.get<std::uint64_t>() : 0;
      if (columns_[c].width > word_bits) throw DecodeError("packed sums have an impossible width");
    }
  }
  place();
}

void Layout::place() {
  for (Column& column : columns_) {
    column.byte = record_bits_ / 8;
    column.shift = static_cast<unsigned>(record_bits_ % 8);
    column.fills_word = column.shift + column.width >= word_bits;
    column.mask = low_bits(column.width);
    record_bits_ += column.width;
  }
}

std::string Layout::header() const {
  ByteWriter out;
  out.put(static_cast<std::uint8_t>((squares_follow_ ? squares_left_out : 0) |
                                    (odd_follows_ ? odd_left_out : 0)));
  for (std::size_t c = 0; c < columns; ++c) {
    if (!leaves_out(c)) {
      const bool based = columns_[c].base != 0;
      out.put(static_cast<std::uint8_t>(columns_[c].width | (based ? has_base : 0)));
      if (based) out.put(columns_[c].base);
    }
  }
  return out.take();
}

void Layout::pack(const PixelSums& pixel, BitWriter& to) const {
  for_each_column([&](auto c) {
    if (columns_[c].width > 0) to.put(at<c>(pixel) ^ columns_[c].base, columns_[c].width);
  });
  if (spare_bits() > 0) to.put(0, spare_bits());
}

/// Unpacks a pixel. Reads up to one word beyond the record.
void Layout::unpack(const char* from, PixelSums& pixel) const {
  for_each_column([&](auto c) {
    const Column& column = columns_[c];
    std::uint64_t word = 0;
    std::memcpy(&word, from + column.byte, word_bytes);
    std::uint64_t value = word >> column.shift;
    if (column.fills_word) {
      const auto next = static_cast<unsigned char>(from[column.byte + word_bytes]);
      value |= std::uint64_t{next} << 1 << (word_bits - 1 - column.shift);
    }
    at<c>(pixel) = column.base | (value & column.mask);
  });
  if (odd_follows_) pixel.odd = pixel.sum;
  if (squares_follow_) {
    for (std::size_t c = 0; c < 3; ++c) {
      pixel.sum_of_squares[c] = square_from(pixel.sum[c], pixel.odd[c]);
    }
  }
}

}  // namespace

void pack_sums(std::span<const PixelSums> pixels, std::string& out) {
  const Layout layout(pixels, {});
  out += layout.header();
  const std::size_t begin = out.size();
  const std::size_t size = pixels.size() * layout.record_bytes();
  out.resize(begin + size + word_bytes);
  BitWriter to(out.data() + begin);
  for (const PixelSums& pixel : pixels) layout.pack(pixel, to);
  to.finish();
  out.resize(begin + size);
}

std::size_t unpack_sums(std::string_view bytes, std::span<PixelSums> pixels) {
  ByteReader in(bytes);
  const Layout layout(in);
  const std::size_t size = layout.record_bytes();
  const std::string_view records = in.get_bytes(pixels.size() * size);
  std::size_t begin = 0;
  unsigned stray = 0;
  std::array<char, sizeof(PixelSums) + word_bytes> last{};
  for (PixelSums& pixel : pixels) {
    const char* from = records.data() + begin;
    if (records.size() - begin < size + word_bytes) {
      std::memcpy(last.data(), from, size);  // here the word beyond the record may be read
      from = last.data();
    }
    layout.unpack(from, pixel);
    stray |= size > 0 ? static_cast<unsigned char>(from[size - 1]) & layout.spare() : 0;
    begin += size;
  }
  // This check rejects every form but the one that pack_sums() writes.
  if (stray != 0 || !bytes.starts_with(Layout(pixels, layout).header())) {
    throw DecodeError("packed sums are not in the form that pack_sums() writes");
  }
  return bytes.size() - in.left();
}

}  // namespace parray::image
