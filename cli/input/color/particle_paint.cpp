#include "cli/input/color/particle_paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "cli/input/color/category_paint.h"
#include "cli/input/particles/source_error.h"
#include "cli/input/select/column_names.h"
#include "cli/input/select/number_source.h"
#include "cli/input/select/selection.h"
#include "common/base/bands.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

constexpr std::size_t block = 512;  ///< of particles that are looked at together
constexpr std::size_t unknown_level = color_levels;

/// Calls take(first, values) for the numbers from `begin` to `end`, block by block.
template <typename Take>
void each_block(const NumberSource& source, std::size_t begin, std::size_t end, const Take& take) {
  std::array<double, block> values{};
  for (std::size_t first = begin; first < end; first += block) {
    const std::span<double> some = std::span(values).first(std::min(block, end - first));
    source.values(first, some);
    take(first, some);
  }
}

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool empty() const { return low > high; }
};

Extent extent_of(const NumberSource& source, std::size_t count, int threads) {
  const Bands bands(count, threads);
  std::vector<Extent> parts(bands.count());
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    Extent part;
    each_block(source, begin, end, [&](std::size_t /*first*/, std::span<const double> values) {
      for (const double value : values) part.add(value);
    });
    parts[band] = part;
  });
  Extent whole;
  for (const Extent& part : parts) {
    whole.low = std::min(whole.low, part.low);
    whole.high = std::max(whole.high, part.high);
  }
  return whole;
}

/// By nearest rank, of the finite numbers, of which there is one at least.
double percentile(const NumberSource& source, std::size_t count, double percent) {
  std::vector<double> finite;
  finite.reserve(count);
  each_block(source, 0, count, [&](std::size_t /*first*/, std::span<const double> values) {
    for (const double value : values) {
      if (std::isfinite(value)) finite.push_back(value);
    }
  });
  const double rank = std::ceil(percent / 100 * static_cast<double>(finite.size()));
  const auto place =
      std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(rank) - 1, 0, std::ssize(finite) - 1);
  std::nth_element(finite.begin(), finite.begin() + place, finite.end());
  return finite[static_cast<std::size_t>(place)];
}

/// What the ends of the map stand for: low < high.
Extent scale_of(const ParticleColoring& coloring, ColorMap map, const NumberSource& source,
                std::size_t count, int threads) {
  Extent scale = extent_of(source, count, threads);
  if (scale.empty()) {
    throw SourceError("color_by", "no particle has a finite " + printable(coloring.by) +
                                      ": colour by something else");
  }
  const TextRange& range = coloring.range;
  if (is_diverging(map) && range.open() && scale.low < 0 && scale.high > 0) {
    scale.high = std::max(scale.high, -scale.low);
    scale.low = -scale.high;
  }
  const auto decide = [&](const std::optional<RangeEnd>& end, double& value) {
    if (end) value = end->percent ? percentile(source, count, end->value) : end->value;
  };
  decide(range.low, scale.low);
  decide(range.high, scale.high);
  if (scale.low < scale.high) return scale;
  if (scale.low > scale.high) {
    throw SourceError("range", "low, " + number_text(scale.low) + ", is above high, " +
                                   number_text(scale.high) + ", in these particles: write both");
  }
  const double room = std::max(std::abs(scale.low) / 2, 0.5);  // all alike: the map's middle
  constexpr double most = std::numeric_limits<double>::max();
  return {std::max(scale.low - room, -most), std::min(scale.high + room, most)};
}

/// How many numbers have no place of their own on the scale.
struct Misfits {
  std::uint64_t unknown = 0;
  std::uint64_t clipped = 0;
};

/// Writes the level of each number of a band to `index`.
Misfits find_levels(const NumberSource& source, const Extent& scale, std::size_t begin,
                    std::size_t end, std::vector<std::uint32_t>& index) {
  Misfits misfits;
  const double half_width = scale.high / 2 - scale.low / 2;  // halves: the width may overflow
  const auto level_of = [&](double value) -> std::size_t {
    if (std::isnan(value)) {
      ++misfits.unknown;
      return unknown_level;
    }
    if (value < scale.low || value > scale.high) ++misfits.clipped;
    const double share =
        (std::clamp(value, scale.low, scale.high) / 2 - scale.low / 2) / half_width;
    return static_cast<std::size_t>(std::lround(share * (color_levels - 1)));
  };
  each_block(source, begin, end, [&](std::size_t first, std::span<const double> values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      index[first + i] = static_cast<std::uint32_t>(level_of(values[i]));
    }
  });
  return misfits;
}

Vec3d in_unit_range(const Vec3d& color) {
  return {std::clamp(color.x, 0.0, 1.0), std::clamp(color.y, 0.0, 1.0),
          std::clamp(color.z, 0.0, 1.0)};
}

/// `count` colours in equal steps.
std::vector<Vec3d> samples_of(ColorMap map, std::size_t count) {
  std::vector<Vec3d> colors;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count - 1);
    colors.push_back(in_unit_range(color_at(map, share)));
  }
  return colors;
}

ParticlePaint painted_by_number(const ParticleColoring& coloring, Particles& particles,
                                int threads) {
  const std::optional<NumberSource> source = NumberSource::of(coloring.by, particles);
  if (!source && is_number_column(coloring.by)) throw UnknownNumber(coloring.by);
  if (!source) {
    throw SourceError("color_by", "the file has no " + printable(coloring.by) + " column");
  }
  const ColorMap map = coloring.map.value_or(ColorMap::viridis);
  const std::size_t count = particles.count();
  const Extent scale = scale_of(coloring, map, *source, count, threads);

  ParticlePaint paint;
  paint.colors = samples_of(map, color_levels);
  paint.colors.push_back(color_of_unknown(map));
  paint.index.resize(count);
  const Bands bands(count, threads);
  std::vector<Misfits> parts(bands.count());
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    parts[band] = find_levels(*source, scale, begin, end, paint.index);
  });
  Misfits misfits;
  for (const Misfits& part : parts) {
    misfits.unknown += part.unknown;
    misfits.clipped += part.clipped;
  }

  constexpr std::size_t legend_stops = 65;
  paint.legend = {coloring.by, {}, scale.low, scale.high, samples_of(map, legend_stops), {}};
  if (misfits.unknown > 0) {
    paint.legend.entries.push_back({"not known", color_of_unknown(map), misfits.unknown});
    particles.facts.notes.push_back({"unknown_numbers", misfits.unknown,
                                     particles_word(misfits.unknown) + " without a known " +
                                         printable(coloring.by) + ", in a colour of their own"});
  }
  if (misfits.clipped > 0) {
    particles.facts.notes.push_back({"clipped", misfits.clipped,
                                     particles_word(misfits.clipped) + " with a " +
                                         printable(coloring.by) + " outside " +
                                         number_text(scale.low) + " to " + number_text(scale.high) +
                                         ", in the colour of the nearer end"});
  }
  return paint;
}

}  // namespace

ParticlePaint painted(const ParticleColoring& coloring, Particles& particles, int threads) {
  const bool category = std::ranges::find(color_by_words, coloring.by) != color_by_words.end();
  return category ? painted_by_category(coloring.by, particles)
                  : painted_by_number(coloring, particles, threads);
}

}  // namespace parray::input
