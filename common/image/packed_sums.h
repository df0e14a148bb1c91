#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "common/image/pixel_sums.h"

/// The sums of a cell of pixels in few bits, without loss.
///
/// A pixel has nine columns of 64 bits: sum, sum_of_squares and odd, each of channels 0, 1, 2.
/// Packed, a cell is a header and a record for each pixel. Numbers are little-endian.
///
///   Header:
///     u8   flags. 1: sum_of_squares is left out, because in every pixel and channel it is
///          square_of(odd) + square_of(sum - odd), modulo 2^64, with square_of(x) =
///          floor(x * x / 2^32) modulo 2^64. So it is where each pixel has at most one sample
///          with an even and one with an odd number.
///          2: odd is left out, because in every pixel and channel it is sum.
///     of each column that is not left out, in order:
///       u8   width in bits, 0 .. 64; plus 128 where a base follows
///       u64  base: the high bits, all but `width`, that all pixels have in common. It follows
///            where it shortens the records by more than 64 bits; else it is 0.
///   Record: the low `width` bits of every column that is not left out, in order and without
///     gaps, bit 0 first, from bit 0 of each byte up. Zeros fill the last byte.
///
/// A value is its base plus its bits. Equal sums have equal bytes: a flag is set wherever it may
/// be, and widths are the least possible. Of no pixels there is a header alone: 3, 0, 0, 0.
namespace parray::image {

/// Appends `pixels` to `out`: at most 82 bytes, and 72 a pixel.
void pack_sums(std::span<const PixelSums> pixels, std::string& out);

/// Reads pixels.size() sums from the beginning of `bytes` and returns how many bytes they took.
/// Throws DecodeError, with anything in `pixels`, unless those are the very bytes that pack_sums()
/// makes of them. Takes no memory that depends on `bytes`.
std::size_t unpack_sums(std::string_view bytes, std::span<PixelSums> pixels);

}  // namespace parray::image
