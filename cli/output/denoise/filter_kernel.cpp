/// Compiled once for each instruction set. All functions must be inline, because other files must
/// not share this code (common/math/inline.h). Therefore it uses no library.
#include "cli/output/denoise/filter_kernel.h"

#include "common/math/lanes.h"
#include PARRAY_LANES

namespace parray::denoise::PARRAY_ISA {
namespace {

using Float = math::PARRAY_ISA::FloatLanes;
using Double = math::PARRAY_ISA::DoubleLanes;

constexpr int features = filter_features;
constexpr int terms = features + 1;  ///< a constant and the slopes
constexpr int pairs = terms * (terms + 1) / 2;
constexpr int lanes = Float::count;
constexpr int window = 2 * filter_reach + 1;
/// Squared distances of patches, relative to pure noise, at which weights are 1 / e.
constexpr float grades[filter_grades] = {0.8F * 0.8F, 2.0F * 2.0F};
/// A squared difference of features. Slopes that rest on smaller differences tend to 0.
constexpr float ridge = 3e-5F;
/// Distance of a patch beyond the picture. Its weight is 0.
constexpr float beyond = 1e30F;

static_assert(tile_width % lanes == 0 && lanes % Double::count == 0);

/// Sums over the windows of the pixels in the lanes.
struct Sums {
  Float moments[pairs];  ///< of 1 and the differences of features from those of the pixel, by pairs
  Float products[terms][3];  ///< of these values with the radiance
};

/// A row of the windows of the pixels in the lanes.
struct WindowRow {
  Float differences[features][window];  ///< of features from those of the pixel
  Float radiance[3][window];
};

/// Returns the place of pixel (x, y) in a tile stored by rows.
PARRAY_INLINE std::ptrdiff_t place(int x, int y) { return std::ptrdiff_t{y} * tile_width + x; }
PARRAY_INLINE int smaller(int a, int b) { return a < b ? a : b; }

/// Approximates exp(-x) for x >= 0 by (1 - x / 16)^16, and 0 from 16 on.
PARRAY_INLINE Float falling(Float x) {
  Float y = max_of(Float(1) - x * Float(1 / 16.0F), Float(0));
  y = y * y;
  y = y * y;
  y = y * y;
  return y * y;
}

PARRAY_INLINE Float sum_of_five(const float* first, std::ptrdiff_t step) {
  Float sum = Float::load(first);
  for (int k = 1; k < 5; ++k) sum = sum + Float::load(first + k * step);
  return sum;
}

/// Compares the patches around the tile's pixels with the patches (dx, dy) away: mean squared
/// difference over pixels and channels. The patches may extend beyond the picture.
PARRAY_INLINE void compare_patches(const FilterPlanes& planes, int x, int y, int dx, int dy,
                                   float* distances) {
  static_assert(patch_reach == 2);
  constexpr int wide = tile_width + 2 * patch_reach;
  constexpr int high = tile_height + 2 * patch_reach;
  constexpr float share = 1.0F / (3 * (2 * patch_reach + 1) * (2 * patch_reach + 1));
  constexpr int last = wide - lanes;
  float squares[high][wide];
  float columns[tile_height][wide];
  for (int j = 0; j < high; ++j) {
    const std::ptrdiff_t row = (y + j - patch_reach) * planes.stride + x - patch_reach;
    for (int i = 0; i < wide; i += lanes) {
      const int from = i < last ? i : last;
      Float sum(0);
      for (int c = 0; c < 3; ++c) {
        const float* const here = planes.radiance[c] + row + from;
        const Float difference = Float::load(here) - Float::load(here + dy * planes.stride + dx);
        sum = sum + difference * difference;
      }
      sum.store(squares[j] + from);
    }
  }
  for (int j = 0; j < tile_height; ++j) {
    for (int i = 0; i < wide; i += lanes) {
      const int from = i < last ? i : last;
      sum_of_five(squares[j] + from, wide).store(columns[j] + from);
    }
  }
  for (int j = 0; j < tile_height; ++j) {
    for (int i = 0; i < tile_width; i += lanes) {
      (sum_of_five(columns[j] + i, 1) * Float(share)).store(distances + place(i, j));
    }
  }
}

/// Sets the distance of patches beyond the picture to `beyond`.
PARRAY_INLINE void cut_off(const FilterPlanes& planes, int x, int y, int dx, int dy,
                           float* distances) {
  const bool columns_inside = x + dx >= 0 && x + dx + tile_width <= planes.width;
  const bool rows_inside = y + dy >= 0 && y + dy + tile_height <= planes.height;
  if (columns_inside && rows_inside) return;
  for (int j = 0; j < tile_height; ++j) {
    const bool row_inside = y + j + dy >= 0 && y + j + dy < planes.height;
    for (int i = 0; i < tile_width; ++i) {
      const bool inside = row_inside && x + i + dx >= 0 && x + i + dx < planes.width;
      if (!inside) distances[place(i, j)] = beyond;
    }
  }
}

/// Adds a row of the window with its weights.
PARRAY_INLINE void add_row(const WindowRow& row, const Float (&weights)[window], Sums& sums) {
  for (int a = 0; a < terms; ++a) {
    Float weighted[window];
    for (int k = 0; k < window; ++k) {
      weighted[k] = a == 0 ? weights[k] : weights[k] * row.differences[a - 1][k];
    }
    Float* const moments = sums.moments + a * (a + 1) / 2;
    for (int k = 0; k < window; ++k) moments[0] = moments[0] + weighted[k];
    for (int b = 1; b <= a; ++b) {
      Float sum = moments[b];
      for (int k = 0; k < window; ++k) sum = sum + weighted[k] * row.differences[b - 1][k];
      moments[b] = sum;
    }
    for (int c = 0; c < 3; ++c) {
      Float sum = sums.products[a][c];
      for (int k = 0; k < window; ++k) sum = sum + weighted[k] * row.radiance[c][k];
      sums.products[a][c] = sum;
    }
  }
}

PARRAY_INLINE void load_row(const FilterPlanes& planes, std::ptrdiff_t at, int dy, WindowRow& row) {
  const std::ptrdiff_t first = at + dy * planes.stride - filter_reach;
  for (int f = 0; f < features; ++f) {
    const Float here = Float::load(planes.own[f] + at);
    for (int k = 0; k < window; ++k) {
      row.differences[f][k] = Float::load(planes.own[f] + first + k) - here;
    }
  }
  for (int c = 0; c < 3; ++c) {
    for (int k = 0; k < window; ++k) {
      row.radiance[c][k] = Float::load(planes.radiance[c] + first + k);
    }
  }
}

/// Computes the weights of a row. `distances` belongs to the first pixel of the row of windows.
/// Consecutive distances are `tile_size` apart.
PARRAY_INLINE void weigh_row(const float* distances, Float by_noise, Float scale,
                             Float (&weights)[window]) {
  for (int k = 0; k < window; ++k) {
    const Float distance = Float::load(distances + std::ptrdiff_t{k} * tile_size);
    weights[k] = falling(max_of(distance - by_noise, Float(0)) * scale);
  }
}

/// Computes Cholesky's factor of the moments: L with the reciprocals of its diagonal on the
/// diagonal. `i` is the first lane.
PARRAY_INLINE void factorise(const Sums& sums, int i, Double (&factor)[pairs]) {
  const auto moment = [&](int pair) {
    float values[lanes];
    sums.moments[pair].store(values);
    return Double::load(values + i);
  };
  const Double weight = moment(0);
  for (int a = 0; a < terms; ++a) {
    for (int b = 0; b <= a; ++b) {
      Double value = moment(a * (a + 1) / 2 + b);
      if (a == b && a > 0) value = value + Double(ridge) * weight;
      for (int k = 0; k < b; ++k) {
        value = value - factor[a * (a + 1) / 2 + k] * factor[b * (b + 1) / 2 + k];
      }
      if (a == b) {
        const Double least = Double(1e-9) * weight;
        factor[a * (a + 1) / 2 + a] = Double(1) / square_root(max_of(value, least));
      } else {
        factor[a * (a + 1) / 2 + b] = value * factor[b * (b + 1) / 2 + b];
      }
    }
  }
}

/// Evaluates the fit for the pixels at `at` with the steady features.
PARRAY_INLINE Double predict(const FilterPlanes& planes, std::ptrdiff_t at,
                             const Double (&factor)[pairs], Double (&z)[terms]) {
  for (int a = 0; a < terms; ++a) {
    for (int k = 0; k < a; ++k) z[a] = z[a] - factor[a * (a + 1) / 2 + k] * z[k];
    z[a] = z[a] * factor[a * (a + 1) / 2 + a];
  }
  for (int a = terms - 1; a >= 0; --a) {
    for (int k = a + 1; k < terms; ++k) z[a] = z[a] - factor[k * (k + 1) / 2 + a] * z[k];
    z[a] = z[a] * factor[a * (a + 1) / 2 + a];
  }
  Double sum = z[0];
  for (int a = 1; a < terms; ++a) {
    sum = sum +
          z[a] * (Double::load(planes.steady[a - 1] + at) - Double::load(planes.own[a - 1] + at));
  }
  return max_of(sum, Double(0));
}

/// Solves the fits of the pixels at `at` and writes their results.
PARRAY_INLINE void solve(const FilterPlanes& planes, std::ptrdiff_t at, const Sums& sums,
                         float* const (&out)[3]) {
  double values[3][lanes];
  for (int i = 0; i < lanes; i += Double::count) {
    Double factor[pairs];
    factorise(sums, i, factor);
    for (int c = 0; c < 3; ++c) {
      Double z[terms];
      for (int a = 0; a < terms; ++a) {
        float products[lanes];
        sums.products[a][c].store(products);
        z[a] = Double::load(products + i);
      }
      predict(planes, at + i, factor, z).store(values[c] + i);
    }
  }
  for (int c = 0; c < 3; ++c) Float::narrow(values[c]).store(out[c] + at);
}

/// Filters the pixels at `at`. `distances` are those of their patches.
PARRAY_INLINE void filter_pixels(const FilterPlanes& planes, std::ptrdiff_t at,
                                 const float* distances) {
  Sums sums[filter_grades];
  for (Sums& sum : sums) {
    for (Float& moment : sum.moments) moment = Float(0);
    for (auto& products : sum.products) {
      for (Float& product : products) product = Float(0);
    }
  }
  const Float by_noise = Float(2) * Float::load(planes.noise + at);
  Float scale[filter_grades];
  for (int grade = 0; grade < filter_grades; ++grade) {
    scale[grade] = Float(1) / (Float(1e-20F) + Float(grades[grade]) * by_noise);
  }
  for (int dy = -filter_reach; dy <= filter_reach; ++dy) {
    WindowRow row;
    load_row(planes, at, dy, row);
    for (int grade = 0; grade < filter_grades; ++grade) {
      Float weights[window];
      weigh_row(distances + std::ptrdiff_t{dy + filter_reach} * window * tile_size, by_noise,
                scale[grade], weights);
      add_row(row, weights, sums[grade]);
    }
  }
  for (int grade = 0; grade < filter_grades; ++grade) {
    solve(planes, at, sums[grade], planes.out[grade]);
  }
}

/// A run of pixels in one row.
struct Run {
  int x;
  int y;
  int count;
};

/// Copies the pixels that are not filtered. Returns their number.
PARRAY_INLINE int keep_plain(const FilterPlanes& planes, const Run& run) {
  if (planes.plain == nullptr) return 0;
  int kept = 0;
  for (int x = run.x; x < run.x + run.count; ++x) {
    if (planes.plain[static_cast<std::ptrdiff_t>(run.y) * planes.width + x] == 0) continue;
    ++kept;
    const std::ptrdiff_t at = run.y * planes.stride + x;
    for (int c = 0; c < 3; ++c) {
      for (int grade = 0; grade < filter_grades; ++grade) {
        planes.out[grade][c][at] = planes.radiance[c][at];
      }
    }
  }
  return kept;
}

}  // namespace

void filter_tile(const FilterPlanes& planes, int x, int y, float* scratch) {
  const int rows = smaller(tile_height, planes.height - y);
  const int columns = smaller(tile_width, planes.width - x);
  int kept = 0;
  for (int j = 0; j < rows; ++j) kept += keep_plain(planes, {x, y + j, columns});
  if (kept == rows * columns) return;
  float* distances = scratch;
  for (int dy = -filter_reach; dy <= filter_reach; ++dy) {
    for (int dx = -filter_reach; dx <= filter_reach; ++dx) {
      compare_patches(planes, x, y, dx, dy, distances);
      cut_off(planes, x, y, dx, dy, distances);
      distances += tile_size;
    }
  }
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; i += lanes) {
      const Run run{x + i, y + j, smaller(lanes, columns - i)};
      if (keep_plain(planes, run) == run.count) continue;
      filter_pixels(planes, (y + j) * planes.stride + x + i, scratch + place(i, j));
      keep_plain(planes, run);
    }
  }
}

}  // namespace parray::denoise::PARRAY_ISA
