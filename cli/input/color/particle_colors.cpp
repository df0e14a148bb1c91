#include "cli/input/color/particle_colors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/residues.h"
#include "cli/input/scene_file/label_settings.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/selection.h"
#include "cli/output/picture/srgb.h"
#include "common/base/bands.h"
#include "common/base/printable.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::array<Vec3d, 7> okabe_ito{{
    {0.7913, 0.3467, 0.0},     // orange
    {0.0931, 0.4564, 0.8148},  // sky blue
    {0.0, 0.3419, 0.1714},     // bluish green
    {0.8714, 0.7758, 0.0545},  // yellow
    {0.0, 0.1683, 0.4452},     // blue
    {0.6654, 0.1119, 0.0},     // vermilion
    {0.6038, 0.1912, 0.3864},  // reddish purple
}};

/// The further colours, in sRGB.
constexpr std::array<std::uint32_t, category_color_count - okabe_ito.size()> grid_colors{
    0x882808, 0xa0ffd0, 0x385068, 0xa068ff, 0x7000a0, 0x7808f0, 0xa84838, 0x58d8ff, 0x886078,
    0xa8e098, 0x88b878, 0xc828c0, 0xf0c048, 0xd0f898, 0xe87838, 0x8090e8, 0x903088};

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

struct Category {
  std::string name;
  Vec3d color;
};

/// Colours particles by category. `index` holds the category of each particle. The legend lists the
/// categories that have particles or are in `names`, in the order `reading`.
ParticleColors colors_by_category(std::string title, const std::vector<Category>& categories,
                                  std::vector<std::uint32_t> index,
                                  const std::vector<std::size_t>& reading,
                                  const std::vector<std::string>& names) {
  ParticleColors colors;
  std::vector<std::uint64_t> counts(categories.size());
  for (const std::uint32_t category : index) ++counts[category];
  for (const Category& category : categories) colors.palette.push_back(category.color);
  colors.index = std::move(index);
  colors.legend.title = std::move(title);
  for (const std::size_t i : reading) {
    const std::string& name =
        categories[i].name.empty() ? std::string(nameless_category) : categories[i].name;
    if (counts[i] == 0 && !contains(names, name)) continue;
    colors.legend.entries.push_back({name, categories[i].color, counts[i]});
  }
  return colors;
}

std::vector<std::size_t> as_they_come(std::size_t count) {
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

ParticleColors by_element(const Particles& particles, const std::vector<std::string>& names) {
  std::vector<Category> categories;
  for (std::size_t number = 0; number <= last_element; ++number) {
    const Element& entry = element(static_cast<std::uint8_t>(number));
    categories.push_back({number == 0 ? "unknown" : std::string(entry.symbol), entry.color});
  }
  std::vector<std::size_t> reading = as_they_come(categories.size());
  std::rotate(reading.begin(), reading.begin() + 1, reading.end());  // "unknown" comes last
  return colors_by_category("element", categories,
                            {particles.elements.begin(), particles.elements.end()}, reading, names);
}

/// Returns whether a name comes before another in a legend: numbers by value, then texts
/// alphabetically, then the empty name.
bool reads_before(const std::string& a, const std::string& b) {
  if (a.empty() != b.empty()) return b.empty();
  const std::optional<double> number_a = number_in(a);
  const std::optional<double> number_b = number_in(b);
  if (number_a && number_b && *number_a != *number_b) return *number_a < *number_b;
  if (number_a.has_value() != number_b.has_value()) return number_a.has_value();
  return a < b;
}

ParticleColors by_name(std::string title, const NameColumn& column,
                       const std::vector<std::string>& names) {
  const std::vector<Vec3d> colors = colors_of_names(column.names);
  std::vector<Category> categories;
  for (std::size_t i = 0; i < colors.size(); ++i) {
    categories.push_back({column.names[i], colors[i]});
  }
  return colors_by_category(std::move(title), categories, column.index, reading_order(column.names),
                            names);
}

/// Colours residues by group. Each residue name without a group is a category of its own.
ParticleColors by_residue(const NameColumn& column, const std::vector<std::string>& names) {
  std::vector<Category> categories;
  for (const std::string_view group : residue_groups()) {
    categories.push_back({std::string(group), category_color(categories.size())});
  }
  std::vector<std::uint32_t> category_of;
  for (const std::string& name : column.names) {
    const std::optional<std::size_t> group = residue_group(name);
    category_of.push_back(static_cast<std::uint32_t>(group.value_or(categories.size())));
    if (!group) categories.push_back({name, category_color(categories.size())});
  }
  std::vector<std::uint32_t> index(column.index.size());
  std::ranges::transform(column.index, index.begin(),
                         [&](std::uint32_t name) { return category_of[name]; });
  return colors_by_category("residue", categories, std::move(index),
                            as_they_come(categories.size()), names);
}

/// Colours by one of color_by_words. Elements have their own colours. Types, chains and atom names
/// get those of category_color() in the order of the legend. Residues: see residue_groups().
///
/// Throws SourceError("color_by") if the particles lack the column.
ParticleColors colored_by_category(const ParticleColoring& coloring, const Particles& particles) {
  const std::string_view word = coloring.by;
  const auto check = [&](bool there, const std::string& what) {
    if (!there) {
      throw SourceError("color_by",
                        "the file has no " + what + ": it has " + columns_of(particles));
    }
  };
  if (word == "element") {
    check(!particles.elements.empty(), "elements");
    return by_element(particles, coloring.names);
  }
  const std::string_view column_word =
      word == "residue" ? "resname" : (word == "atom" ? "name" : word);
  const NameColumn& column = name_column(column_word, particles);
  check(!column.empty(), plural_of(column_word));
  return word == "residue" ? by_residue(column, coloring.names)
                           : by_name(coloring.by, column, coloring.names);
}

constexpr std::size_t block_size = 512;  ///< number of particles that are processed together
constexpr std::size_t unknown_level = color_levels;

/// Calls take(first, values) for the numbers from `begin` to `end`, block by block.
void each_block(const NumberSource& source, std::size_t begin, std::size_t end, const auto& take) {
  std::array<double, block_size> values{};
  for (std::size_t first = begin; first < end; first += block_size) {
    const std::span<double> some = std::span(values).first(std::min(block_size, end - first));
    source(first, some);
    take(first, some);
  }
}

bool can_be_end(double value, NumberScale scale) {
  return std::isfinite(value) && (scale != NumberScale::log || value > 0);
}

NumberBounds extent_of(const NumberSource& source, std::size_t count, NumberScale scale,
                       int threads) {
  const Bands bands(count, threads);
  std::vector<NumberBounds> parts(bands.count());
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    NumberBounds part;
    each_block(source, begin, end, [&](std::size_t /*first*/, std::span<const double> values) {
      for (const double value : values) {
        if (can_be_end(value, scale)) part.add(value);
      }
    });
    parts[band] = part;
  });
  NumberBounds whole;
  for (const NumberBounds& part : parts) whole.add(part);
  return whole;
}

/// Returns a percentile, by nearest rank, of the numbers that can be ends. There must be such a
/// number.
double percentile(const NumberSource& source, std::size_t count, NumberScale scale,
                  double percent) {
  std::vector<double> finite;
  finite.reserve(count);
  each_block(source, 0, count, [&](std::size_t /*first*/, std::span<const double> values) {
    for (const double value : values) {
      if (can_be_end(value, scale)) finite.push_back(value);
    }
  });
  const double rank = std::ceil(percent / 100 * static_cast<double>(finite.size()));
  const auto place =
      std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(rank) - 1, 0, std::ssize(finite) - 1);
  std::nth_element(finite.begin(), finite.begin() + place, finite.end());
  return finite[static_cast<std::size_t>(place)];
}

/// Returns the numbers at the ends of the map: low <= high.
NumberBounds ends_of(const ParticleColoring& coloring, ColorMap map, const NumberSource& source,
                     std::size_t count, int threads) {
  const NumberScale kind = coloring.scale.value_or(NumberScale::linear);
  const bool log = kind == NumberScale::log;
  NumberBounds scale = extent_of(source, count, kind, threads);
  if (scale.empty()) {
    throw SourceError("color_by", std::string("no particle has a ") +
                                      (log ? "positive " : "finite ") + printable(coloring.by) +
                                      ": choose another column");
  }
  const TextRange& range = coloring.range;
  if (is_diverging(map) && range.open() && !log && scale.low < 0 && scale.high > 0) {
    scale.high = std::max(scale.high, -scale.low);
    scale.low = -scale.high;
  }
  const auto decide = [&](const std::optional<RangeEnd>& end, double& value) {
    if (end) value = end->percent ? percentile(source, count, kind, end->value) : end->value;
  };
  decide(range.low, scale.low);
  decide(range.high, scale.high);
  if (log && !(scale.low > 0)) {
    throw SourceError("range", "a logarithmic scale cannot begin at " + number_text(scale.low) +
                                   ": write a low end above 0");
  }
  if (scale.low > scale.high) {
    throw SourceError(
        "range", "low (" + number_text(scale.low) + ") is above high (" + number_text(scale.high) +
                     ") for these particles: give both ends as numbers, the smaller first");
  }
  return scale;
}

/// Returns a scale with low < high, both finite, and low > 0 on a logarithmic scale. If all numbers
/// are equal, they get the middle of the map, or an end of it where double's range ends.
NumberBounds scale_of(const NumberBounds& ends, NumberScale kind) {
  if (ends.low < ends.high) return ends;
  constexpr double most = std::numeric_limits<double>::max();
  if (kind == NumberScale::log) {
    constexpr double least = std::numeric_limits<double>::denorm_min();
    return {std::max(ends.low / 2, least), std::min(ends.high * 2, most)};
  }
  const double room = std::max(std::abs(ends.low) / 2, 0.5);
  return {std::max(ends.low - room, -most), std::min(ends.high + room, most)};
}

/// How many numbers are unknown, and how many lie outside the scale.
struct Misfits {
  std::uint64_t unknown = 0;
  std::uint64_t clipped = 0;
};

/// Writes the level of each number of a band to `index`.
Misfits find_levels(const NumberSource& source, const NumberBounds& scale, NumberScale kind,
                    std::size_t begin, std::size_t end, std::vector<std::uint32_t>& index) {
  Misfits misfits;
  const auto on_scale = [kind](double value) {
    return kind == NumberScale::log ? std::log(value) : value;
  };
  const double low = on_scale(scale.low);
  const double half_width = on_scale(scale.high) / 2 - low / 2;  // half: the width may overflow
  const auto level_of = [&](double value) -> std::size_t {
    if (std::isnan(value) || (kind == NumberScale::log && value <= 0)) {
      ++misfits.unknown;
      return unknown_level;
    }
    if (value < scale.low || value > scale.high) ++misfits.clipped;
    const double share =
        (on_scale(std::clamp(value, scale.low, scale.high)) / 2 - low / 2) / half_width;
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

/// Samples `count` colours of a map in equal steps.
std::vector<Vec3d> samples_of(ColorMap map, std::size_t count) {
  std::vector<Vec3d> colors;
  for (std::size_t i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count - 1);
    colors.push_back(in_unit_range(color_at(map, share)));
  }
  return colors;
}

/// Colours each number by itself. Throws SourceError if there are more than most_categories.
ParticleColors colored_by_each_number(const ParticleColoring& coloring,
                                      const Particles& particles) {
  constexpr std::size_t most_categories = 1000;
  const std::string& by = coloring.by;
  const NumberSource source = known_number("color_by", by, particles);
  NameColumn column;
  std::map<double, std::uint32_t> known;
  constexpr double not_known = std::numeric_limits<double>::infinity();
  for (const std::string& name : coloring.names) {
    const bool nameless = name == nameless_category;
    const std::optional<double> number = nameless ? not_known : number_in(name);
    if (!number || !known.try_emplace(*number, column.names.size()).second) continue;
    column.names.push_back(nameless ? "" : number_text(*number));
  }
  each_block(source, 0, particles.count(),
             [&](std::size_t /*first*/, std::span<const double> values) {
               for (const double value : values) {
                 // An unknown number has an empty name. -0 + 0 is +0.
                 const bool is_known = std::isfinite(value);
                 const double key = is_known ? value + 0.0 : not_known;
                 const auto [entry, is_new] =
                     known.try_emplace(key, static_cast<std::uint32_t>(column.names.size()));
                 if (is_new) column.names.push_back(is_known ? number_text(key) : "");
                 if (column.names.size() > most_categories) {
                   throw SourceError("color_scale", printable(by) + " has more than " +
                                                        std::to_string(most_categories) +
                                                        " different numbers: use linear or log");
                 }
                 column.index.push_back(entry->second);
               }
             });
  return by_name(by, column, coloring.names);
}

ParticleColors colored_by_number(const ParticleColoring& coloring, Particles& particles,
                                 int threads) {
  const NumberSource source = known_number("color_by", coloring.by, particles);
  const NumberScale kind = coloring.scale.value_or(NumberScale::linear);
  const ColorMap map = coloring.map.value_or(ColorMap::viridis);
  const std::size_t count = particles.count();
  ParticleColors colors;
  colors.numbers = ends_of(coloring, map, source, count, threads);
  const NumberBounds scale = scale_of(colors.numbers, kind);
  colors.palette = samples_of(map, color_levels);
  colors.palette.push_back(color_of_unknown(map));
  colors.index.resize(count);
  const Bands bands(count, threads);
  std::vector<Misfits> parts(bands.count());
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    parts[band] = find_levels(source, scale, kind, begin, end, colors.index);
  });
  Misfits misfits;
  for (const Misfits& part : parts) {
    misfits.unknown += part.unknown;
    misfits.clipped += part.clipped;
  }

  constexpr std::size_t legend_stops = 65;
  const std::string unit = unit_of(coloring.by, particles);
  colors.legend = {.title = coloring.by,
                   .unit = std::string(unit_sign(unit)),
                   .low = scale.low,
                   .high = scale.high,
                   .stops = samples_of(map, legend_stops),
                   .log = kind == NumberScale::log};
  const std::string not_known = "not known";
  if (misfits.unknown > 0 || contains(coloring.names, not_known)) {
    colors.legend.entries.push_back({not_known, color_of_unknown(map), misfits.unknown});
  }
  particles.facts.note(
      "unknown_numbers", misfits.unknown,
      particles_word(misfits.unknown) +
          (kind == NumberScale::log ? " without a positive " : " without a known ") +
          printable(coloring.by) + ", in a separate colour");
  particles.facts.note("clipped", misfits.clipped,
                       particles_word(misfits.clipped) + " whose " + printable(coloring.by) +
                           " is outside " + number_text(scale.low) + " to " +
                           number_text(scale.high) + ", in the colour of the nearer end");
  return colors;
}

}  // namespace

Vec3d category_color(std::size_t number) {
  number %= category_color_count;
  if (number < okabe_ito.size()) return okabe_ito[number];
  return linear_of_code(grid_colors[number - okabe_ito.size()]);
}

std::vector<std::size_t> reading_order(const std::vector<std::string>& names) {
  std::vector<std::size_t> order = as_they_come(names.size());
  std::ranges::sort(order,
                    [&](std::size_t a, std::size_t b) { return reads_before(names[a], names[b]); });
  return order;
}

std::vector<Vec3d> colors_of_names(const std::vector<std::string>& names) {
  const auto number_of = [](const std::string& name) {
    const std::optional<std::uint64_t> number = natural_in(name);
    return number && *number <= category_color_count ? *number : 0;
  };
  const bool numbered =
      std::ranges::all_of(names, [&](const std::string& name) { return number_of(name) > 0; });
  const std::vector<std::size_t> order = reading_order(names);
  std::vector<Vec3d> colors(names.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::string& name = names[order[i]];
    colors[order[i]] = category_color(numbered ? number_of(name) - 1 : i);
  }
  return colors;
}

ParticleColors colors_of(const ParticleColoring& coloring, Particles& particles, int threads) {
  const bool category = std::ranges::find(color_by_words, coloring.by) != color_by_words.end();
  if (coloring.scale == NumberScale::categories) return colored_by_each_number(coloring, particles);
  return category ? colored_by_category(coloring, particles)
                  : colored_by_number(coloring, particles, threads);
}

}  // namespace parray::input
