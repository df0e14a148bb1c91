#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

#include "common/image/pixel_sums.h"

/// Packs the sums of a cell of pixels without loss.
///
/// A pixel has nine columns of 64 bits: sum, sum_of_squares and odd, each of channels 0, 1, 2. A
/// packed cell is a header and a record for each pixel. Numbers are little-endian.
///
///   Header:
///     u8   flags. 1: sum_of_squares is left out, because in every pixel and channel it is
///          square_of(odd) + square_of(sum - odd), modulo 2^64, with square_of(x) =
///          floor(x * x / 2^32) modulo 2^64. This holds if each pixel has at most one sample
///          with an even and one with an odd number.
///          2: odd is left out, because in every pixel and channel it equals sum.
///     for each column that is not left out, in order:
///       u8   width in bits, 0 .. 64; plus 128 if a base follows
///       u64  base: the high bits, all but `width`, that all pixels have in common. The base
///            follows if it shortens the records by more than 64 bits; otherwise it is 0.
///   Record: the low `width` bits of every column that is not left out, in order and without
///     gaps, bit 0 first, starting at bit 0 of each byte. Zeros fill the last byte.
///
/// A value is its base plus its bits. Equal sums give equal bytes: a flag is set whenever possible,
/// and widths are the smallest possible. A cell without pixels is a header alone: 3, 0, 0, 0.
namespace parray::image {

/// Appends the packed `pixels` to `out`: at most 82 bytes plus 72 bytes per pixel.
void pack_sums(std::span<const PixelSums> pixels, std::string& out);

/// Reads pixels.size() sums from the beginning of `bytes` and returns the number of bytes read.
/// Throws DecodeError unless these are exactly the bytes that pack_sums() writes for the sums; the
/// content of `pixels` is then undefined. The memory that the function allocates does not grow with
/// `bytes`.
std::size_t unpack_sums(std::string_view bytes, std::span<PixelSums> pixels);

}  // namespace parray::image
