#include "cli/input/formats/xtc_coordinates.h"

#include <bit>
#include <cmath>
#include <cstddef>

namespace parray::input {
namespace {

__extension__ using Wide = unsigned __int128;
using Whole = std::array<std::int64_t, 3>;
using Sizes = std::array<std::uint64_t, 3>;

/// Sizes of differences, by their place: about 2^(place / 3), as the format has them.
constexpr std::array<std::uint32_t, 73> small_sizes{
    0,        0,        0,       0,       0,       0,       0,       0,       0,       8,
    10,       12,       16,      20,      25,      32,      40,      50,      64,      80,
    101,      128,      161,     203,     256,     322,     406,     512,     645,     812,
    1024,     1290,     1625,    2048,    2580,    3250,    4096,    5060,    6501,    8192,
    10321,    13003,    16384,   20642,   26007,   32768,   41285,   52015,   65536,   82570,
    104031,   131072,   165140,  208063,  262144,  330280,  416127,  524287,  660561,  832255,
    1048576,  1321122,  1664510, 2097152, 2642245, 3329021, 4194304, 5284491, 6658042, 8388607,
    10568983, 13316085, 16777216};
constexpr std::int32_t first_small = 9;

[[noreturn]] void fail_damaged(const FilePlace& place) {
  place.fail("packed coordinates that cannot be: is the file damaged?");
}

/// Bits from the highest of each byte to the lowest.
class Bits {
 public:
  Bits(std::string_view bytes, const FilePlace& place) : bytes_(bytes), place_(place) {}

  /// At most 32.
  std::uint64_t take(unsigned count) {
    while (held_ < count) {
      if (next_ == bytes_.size()) fail_damaged(place_);
      held_bits_ = (held_bits_ << 8) | static_cast<unsigned char>(bytes_[next_++]);
      held_ += 8;
    }
    held_ -= count;
    return (held_bits_ >> held_) & ((std::uint64_t{1} << count) - 1);
  }

  /// A number of `count` bits whose bytes, but for the bits of the last, go from low to high.
  Wide take_wide(unsigned count) {
    Wide value = 0;
    for (unsigned at = 0; at < count; at += 8) {
      const unsigned part = std::min(count - at, 8U);
      value |= static_cast<Wide>(take(part)) << at;
    }
    return value;
  }

 private:
  std::string_view bytes_;
  const FilePlace& place_;
  std::size_t next_ = 0;
  std::uint64_t held_bits_ = 0;
  unsigned held_ = 0;
};

/// Three numbers below `sizes`, as the digits of one of `bits` bits.
template <typename Number>
Whole digits_of(Number number, const Sizes& sizes) {
  Whole digits{};
  for (const std::size_t axis : {2U, 1U}) {
    digits.at(axis) = static_cast<std::int64_t>(number % sizes.at(axis));
    number /= sizes.at(axis);
  }
  digits[0] = static_cast<std::int64_t>(number);
  return digits;
}

Whole take_digits(Bits& bits, unsigned count, const Sizes& sizes) {
  const Wide number = bits.take_wide(count);
  constexpr unsigned narrow = 64;  // whose division is many times faster
  return count <= narrow ? digits_of(static_cast<std::uint64_t>(number), sizes)
                         : digits_of(number, sizes);
}

Whole sum(const Whole& a, const Whole& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }

class XtcUnpacker {
 public:
  XtcUnpacker(const XtcPacking& packing, std::string_view bytes, const FilePlace& place)
      : packing_(packing), place_(place), bits_(bytes, place), small_(packing.small) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      least_.at(axis) = packing.least.at(axis);
      const std::int64_t size = std::int64_t{packing.most.at(axis)} - packing.least.at(axis) + 1;
      if (size < 1 || size > UINT32_MAX) fail_damaged(place);
      sizes_.at(axis) = static_cast<std::uint64_t>(size);
      by_axis_ = by_axis_ || size > widest_in_one;
    }
    if (!(packing.precision > 0) || !std::isfinite(packing.precision)) fail_damaged(place);
    check_small();
  }

  std::vector<Vec3d> all() {
    while (positions_.size() < packing_.atoms) take_group();
    return std::move(positions_);
  }

 private:
  static constexpr std::int64_t widest_in_one = 0xFFFFFF;

  /// A position, and the differences that follow it.
  void take_group() {
    Whole position = sum(take_position(), least_);
    int change = 0;
    if (bits_.take(1) == 1) {
      const auto code = static_cast<int>(bits_.take(5));
      change = code % 3 - 1;
      run_ = code / 3;
    }
    if (run_ == 0) {
      put(position);
    } else {
      take_differences(position);
    }
    small_ += change;  // after the last difference, perhaps beyond the sizes that there are
  }

  Whole take_position() {
    if (!by_axis_) return take_digits(bits_, bits_in_one(), sizes_);
    Whole digits{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      digits.at(axis) = static_cast<std::int64_t>(bits_.take(width(sizes_.at(axis))));
    }
    return digits;
  }

  void take_differences(const Whole& position) {
    check_small();
    const std::uint64_t size = small_sizes.at(static_cast<std::size_t>(small_));
    const auto half = static_cast<std::int64_t>(size / 2);
    const Whole back{-half, -half, -half};
    Whole before = position;
    for (int i = 0; i < run_; ++i) {
      const Whole digits = take_digits(bits_, static_cast<unsigned>(small_), {size, size, size});
      before = sum(sum(before, digits), back);
      put(before);
      if (i == 0) put(position);
    }
  }

  void put(const Whole& whole) {
    if (positions_.size() == packing_.atoms) fail_damaged(place_);
    const auto length = [&](std::int64_t x) { return static_cast<double>(x) / packing_.precision; };
    positions_.push_back({length(whole[0]), length(whole[1]), length(whole[2])});
  }

  void check_small() const {
    if (small_ < first_small || static_cast<std::size_t>(small_) >= small_sizes.size()) {
      fail_damaged(place_);
    }
  }

  static unsigned width(std::uint64_t number) {
    return static_cast<unsigned>(std::bit_width(number));
  }
  [[nodiscard]] unsigned bits_in_one() const {
    const Wide product = static_cast<Wide>(sizes_[0]) * sizes_[1] * sizes_[2];
    const auto high = static_cast<std::uint64_t>(product >> 64);
    return high != 0 ? 64 + width(high) : width(static_cast<std::uint64_t>(product));
  }

  const XtcPacking& packing_;
  const FilePlace& place_;
  Bits bits_;
  Whole least_{};
  Sizes sizes_{};
  bool by_axis_ = false;  // each coordinate on its own
  std::int32_t small_;    // place of the present size of differences
  int run_ = 0;           // differences after each position, until another count comes
  std::vector<Vec3d> positions_;
};

}  // namespace

std::vector<Vec3d> unpack_xtc(const XtcPacking& packing, std::string_view bytes,
                              const FilePlace& place) {
  return XtcUnpacker(packing, bytes, place).all();
}

}  // namespace parray::input
