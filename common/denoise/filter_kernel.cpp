/// Compiled once for each instruction set. Loops over a row of a tile become vectors; nothing that
/// other files share may be left out of line here (see common/math/inline.h), so there is no
/// library in it.
#include "common/denoise/filter_kernel.h"

#include "common/math/inline.h"

namespace parray::PARRAY_ISA {
namespace {

constexpr int features = filter_features;
constexpr int terms = features + 1;  ///< a constant and the slopes
constexpr int pairs = terms * (terms + 1) / 2;
constexpr int lanes = tile_width;
/// Distances of patches, in what noise alone makes them, at which weights have fallen to 1 / e.
constexpr float grades[filter_grades] = {0.8F * 0.8F, 2.0F * 2.0F};
/// Of a feature, squared: slopes that rest on less than that are drawn to 0.
constexpr float ridge = 3e-5F;

using Row = float[lanes];
using Doubles = double[lanes];

struct Sums {
  Row moments[pairs];      ///< of 1 and the features' differences from the pixel's, by pairs
  Row products[terms][3];  ///< of these with the radiance
};

PARRAY_INLINE float larger(float a, float b) { return a > b ? a : b; }
PARRAY_INLINE int smaller(int a, int b) { return a < b ? a : b; }

/// exp(-x) for x >= 0 as (1 - x / 16)^16, which is 0 from 16 on.
PARRAY_INLINE float falling(float x) {
  float y = larger(1 - x * (1 / 16.0F), 0.0F);
  y *= y;
  y *= y;
  y *= y;
  return y * y;
}

/// Of the patches around the tile's pixels and around those (dx, dy) away: mean over pixels and
/// channels of the squared difference.
PARRAY_INLINE void measure(const FilterPlanes& planes, int x, int y, int dx, int dy,
                           float* distances) {
  constexpr int wide = tile_width + 2 * patch_reach;
  constexpr int high = tile_height + 2 * patch_reach;
  constexpr float share = 1.0F / (3 * (2 * patch_reach + 1) * (2 * patch_reach + 1));
  float rows[high][tile_width];
  for (int j = 0; j < high; ++j) {
    float squares[wide] = {};
    const std::ptrdiff_t at = (y + j - patch_reach) * planes.stride + x - patch_reach;
    for (int c = 0; c < 3; ++c) {
      const float* const here = planes.radiance[c] + at;
      const float* const there = here + dy * planes.stride + dx;
      for (int i = 0; i < wide; ++i) {
        const float difference = here[i] - there[i];
        squares[i] += difference * difference;
      }
    }
    for (int i = 0; i < tile_width; ++i) {
      rows[j][i] = squares[i] + squares[i + 1] + squares[i + 2] + squares[i + 3] + squares[i + 4];
    }
  }
  for (int j = 0; j < tile_height; ++j) {
    for (int i = 0; i < tile_width; ++i) {
      distances[j * tile_width + i] =
          (rows[j][i] + rows[j + 1][i] + rows[j + 2][i] + rows[j + 3][i] + rows[j + 4][i]) * share;
    }
  }
}

/// Adds what the pixels `offset` away say, by their weights.
PARRAY_INLINE void gather(const FilterPlanes& planes, std::ptrdiff_t at, std::ptrdiff_t offset,
                          const Row (&weights)[filter_grades], Sums (&sums)[filter_grades]) {
  Row difference[features];
  for (int f = 0; f < features; ++f) {
    const float* const here = planes.own[f] + at;
    for (int i = 0; i < lanes; ++i) difference[f][i] = here[i + offset] - here[i];
  }
  for (int grade = 0; grade < filter_grades; ++grade) {
    Sums& sum = sums[grade];
    for (int a = 0; a < terms; ++a) {
      Row weighted;
      for (int i = 0; i < lanes; ++i) {
        weighted[i] = a == 0 ? weights[grade][i] : weights[grade][i] * difference[a - 1][i];
      }
      Row* const moments = sum.moments + a * (a + 1) / 2;
      for (int i = 0; i < lanes; ++i) moments[0][i] += weighted[i];
      for (int b = 1; b <= a; ++b) {
        for (int i = 0; i < lanes; ++i) moments[b][i] += weighted[i] * difference[b - 1][i];
      }
      for (int c = 0; c < 3; ++c) {
        const float* const radiance = planes.radiance[c] + at + offset;
        for (int i = 0; i < lanes; ++i) sum.products[a][c][i] += weighted[i] * radiance[i];
      }
    }
  }
}

/// Cholesky's factor of the moments, in place: L with its diagonal's reciprocals on the diagonal.
PARRAY_INLINE void factorise(const Sums& sums, Doubles (&factor)[pairs]) {
  for (int a = 0; a < terms; ++a) {
    for (int b = 0; b <= a; ++b) {
      Doubles& entry = factor[a * (a + 1) / 2 + b];
      for (int i = 0; i < lanes; ++i) {
        const double weight = static_cast<double>(sums.moments[0][i]);
        double value = static_cast<double>(sums.moments[a * (a + 1) / 2 + b][i]);
        if (a == b && a > 0) value += static_cast<double>(ridge) * weight;
        for (int k = 0; k < b; ++k) {
          value -= factor[a * (a + 1) / 2 + k][i] * factor[b * (b + 1) / 2 + k][i];
        }
        if (a == b) {
          const double least = 1e-9 * weight;
          entry[i] = 1 / __builtin_sqrt(value > least ? value : least);
        } else {
          entry[i] = value * factor[b * (b + 1) / 2 + b][i];
        }
      }
    }
  }
}

/// What the fit says of a pixel with the steady features.
PARRAY_INLINE void predict(const FilterPlanes& planes, std::ptrdiff_t at,
                           const Doubles (&factor)[pairs], const Sums& sums, int channel,
                           Row& out) {
  Doubles z[terms];
  for (int a = 0; a < terms; ++a) {
    for (int i = 0; i < lanes; ++i) {
      double value = static_cast<double>(sums.products[a][channel][i]);
      for (int k = 0; k < a; ++k) value -= factor[a * (a + 1) / 2 + k][i] * z[k][i];
      z[a][i] = value * factor[a * (a + 1) / 2 + a][i];
    }
  }
  Doubles sum;
  for (int a = terms - 1; a >= 0; --a) {
    for (int i = 0; i < lanes; ++i) {
      double value = z[a][i];
      for (int k = a + 1; k < terms; ++k) value -= factor[k * (k + 1) / 2 + a][i] * z[k][i];
      z[a][i] = value * factor[a * (a + 1) / 2 + a][i];
    }
  }
  for (int i = 0; i < lanes; ++i) sum[i] = z[0][i];
  for (int a = 1; a < terms; ++a) {
    const float* const own = planes.own[a - 1] + at;
    const float* const steady = planes.steady[a - 1] + at;
    for (int i = 0; i < lanes; ++i) sum[i] += z[a][i] * static_cast<double>(steady[i] - own[i]);
  }
  for (int i = 0; i < lanes; ++i) out[i] = sum[i] > 0 ? static_cast<float>(sum[i]) : 0.0F;
}

/// Where the k-th pixel of the window lies.
constexpr int window = 2 * filter_reach + 1;
PARRAY_INLINE int column_of(std::ptrdiff_t k) {
  return static_cast<int>(k % window) - filter_reach;
}
PARRAY_INLINE int row_of(std::ptrdiff_t k) { return static_cast<int>(k / window) - filter_reach; }

/// Weights of a row's pixels `dx`, `dy` away: 0 beyond the picture.
PARRAY_INLINE void weigh(const FilterPlanes& planes, int x, int y, int dx, int dy,
                         const float* distances, Row (&weights)[filter_grades]) {
  const bool row_inside = y + dy >= 0 && y + dy < planes.height;
  const int begin = -dx - x;
  const int end = planes.width - dx - x;
  const float* const noise = planes.noise + y * planes.stride + x;
  for (int grade = 0; grade < filter_grades; ++grade) {
    for (int i = 0; i < lanes; ++i) {
      const float by_noise = 2 * noise[i];
      const float excess = larger(distances[i] - by_noise, 0.0F);
      const float weight = falling(excess / (1e-20F + grades[grade] * by_noise));
      weights[grade][i] = row_inside && i >= begin && i < end ? weight : 0.0F;
    }
  }
}

}  // namespace

void filter_tile(const FilterPlanes& planes, int x, int y, float* scratch) {
  constexpr std::ptrdiff_t tile = std::ptrdiff_t{tile_width} * tile_height;
  for (std::ptrdiff_t k = 0; k < filter_offsets; ++k) {
    measure(planes, x, y, column_of(k), row_of(k), scratch + k * tile);
  }
  const int rows = smaller(tile_height, planes.height - y);
  const int columns = smaller(tile_width, planes.width - x);
  for (int j = 0; j < rows; ++j) {
    const std::ptrdiff_t at = (y + j) * planes.stride + x;
    Sums sums[filter_grades] = {};
    for (std::ptrdiff_t k = 0; k < filter_offsets; ++k) {
      Row weights[filter_grades];
      weigh(planes, x, y + j, column_of(k), row_of(k),
            scratch + k * tile + std::ptrdiff_t{j} * tile_width, weights);
      gather(planes, at, row_of(k) * planes.stride + column_of(k), weights, sums);
    }
    for (int grade = 0; grade < filter_grades; ++grade) {
      Doubles factor[pairs];
      factorise(sums[grade], factor);
      for (int c = 0; c < 3; ++c) {
        Row out;
        predict(planes, at, factor, sums[grade], c, out);
        for (int i = 0; i < columns; ++i) planes.out[grade][c][at + i] = out[i];
      }
    }
  }
}

}  // namespace parray::PARRAY_ISA
