#pragma once

#include <cstdint>

#include "common/image/pixel_sums.h"
#include "common/trace/integrator/kernel_scene.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

/// Adds the samples of a batch to their pixels, like PixelSums::add(), but with the channels of a
/// sample side by side.
namespace parray::trace {

/// Red, green, blue, and 0, in the fixed point of RadianceScale.
using FixedColor = std::uint64_t __attribute__((vector_size(32)));

/// Adds squares, like RadianceScale::square_of(). Values are at most 2^32, and the shifted square
/// of 2^32 is 2^32 itself: one bit.
PARRAY_INLINE void add_squares(FixedColor& sums, const FixedColor& values) {
#if defined(__AVX2__)
  const auto v = reinterpret_cast<__m256i>(values);
  sums += reinterpret_cast<FixedColor>(_mm256_srli_epi64(_mm256_mul_epu32(v, v), 32));
#else
  const FixedColor low = values & 0xFFFFFFFF;
  sums += low * low >> 32;
#endif
  sums += values & std::uint64_t{1} << 32;
}

/// The sums of consecutive samples of a batch that belong to one pixel.
struct RunSums {
  FixedColor sum{}, sum_of_squares{}, odd{};
  FixedColor used{};  ///< bits set in any sample; a bit above 2^32 means that a sample is NaN

  PARRAY_INLINE void add(const FixedColor& values, std::uint32_t sample) {
    sum += values;
    add_squares(sum_of_squares, values);
    odd += values & (0 - std::uint64_t{sample & 1});
    used |= values;
  }

  static PARRAY_INLINE bool is_number(const FixedColor& values) {
    return (values[0] | values[1] | values[2]) >> 33 == 0;
  }

  PARRAY_INLINE void add_to(PixelSums& pixel) const {
    // NOLINTBEGIN(readability-simplify-subscript-expr): [] takes unsigned numbers
    for (int channel = 0; channel < 3; ++channel) {
      pixel.sum.data()[channel] += sum[channel];
      pixel.sum_of_squares.data()[channel] += sum_of_squares[channel];
      pixel.odd.data()[channel] += odd[channel];
    }
    // NOLINTEND(readability-simplify-subscript-expr)
  }
};

/// Loads a sample's values, which are stored with RadianceScale::shift added. (They are not a
/// return value, because compilers may not know vectors of that length.)
PARRAY_INLINE void load_color(const BatchRadiance& radiance, std::uint32_t i, FixedColor& values) {
  __builtin_memcpy(&values, radiance.of[i], sizeof values);
  values -= __builtin_bit_cast(std::uint64_t, RadianceScale::shift);
}

/// Returns the sums of samples [begin, end) of a batch. All must be of one pixel and finite.
PARRAY_INLINE RunSums sums_of_run(const SampleBatch& batch, const BatchRadiance& radiance,
                                  std::uint32_t begin, std::uint32_t end) {
  RunSums sums;
  for (std::uint32_t i = begin; i < end; ++i) {
    FixedColor values;
    load_color(radiance, i, values);
    sums.add(values, batch.sample[i]);
  }
  return sums;
}

/// Returns the sums of the finite samples of [begin, end), which must be of one pixel. Counts the
/// others in counts.nonfinite.
PARRAY_INLINE RunSums sums_of_numbers(const SampleBatch& batch, const BatchRadiance& radiance,
                                      std::uint32_t begin, std::uint32_t end, TraceCounts& counts) {
  RunSums sums;
  for (std::uint32_t i = begin; i < end; ++i) {
    FixedColor values;
    load_color(radiance, i, values);
    if (RunSums::is_number(values)) {
      sums.add(values, batch.sample[i]);
    } else {
      ++counts.nonfinite;
    }
  }
  return sums;
}

/// Adds all samples of a batch to the pixels of its row: row[x] is the pixel in column x. Counts
/// non-finite samples instead.
PARRAY_INLINE void add_samples(const SampleBatch& batch, const BatchRadiance& radiance,
                               PixelSums* row, TraceCounts& counts) {
  for (std::uint32_t i = 0; i < batch.count;) {
    const std::uint32_t begin = i;
    const std::uint32_t x = batch.column[i];
    while (i < batch.count && batch.column[i] == x) ++i;
    RunSums sums = sums_of_run(batch, radiance, begin, i);
    if (!RunSums::is_number(sums.used)) [[unlikely]] {
      sums = sums_of_numbers(batch, radiance, begin, i, counts);
    }
    sums.add_to(row[x]);
  }
  counts.samples += batch.count;
}

}  // namespace parray::trace
