#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/vec.h"

namespace parray::input {

/// A colour and its meaning.
struct LegendEntry {
  std::string name;         ///< UTF-8, as people read it; not empty
  Vec3d color{};            ///< linear RGB in [0, 1]: the particles' albedo
  std::uint64_t count = 0;  ///< number of particles of this category
  /// True: the entry states the value of the longest arrow. It then has no colour and no count.
  bool arrow = false;

  friend bool operator==(const LegendEntry&, const LegendEntry&) = default;
};

/// The meaning of particles' colours: a scale, categories, or both. Or the value of the longest
/// arrow: entries with `arrow`, and no scale.
/// - A scale of numbers: `stops` are at least two colours from `low` to `high` in equal steps, with
/// linear interpolation between them.
/// - Categories: `entries`, in display order. Next to a scale, they explain colours outside the
/// scale, such as "not known".
struct Legend {
  std::string title{};  ///< a word such as "element", the name of a number, or the arrows' vector
  std::string unit{};   ///< of the numbers; empty: unknown or none
  double low = 0;       ///< of a scale: finite, below `high`
  double high = 0;
  std::vector<Vec3d> stops{};  ///< linear RGB in [0, 1]; empty: no scale
  std::vector<LegendEntry> entries{};
  bool log = false;  ///< the scale has equal steps of the logarithm; low > 0

  [[nodiscard]] bool empty() const { return stops.empty() && entries.empty(); }
  friend bool operator==(const Legend&, const Legend&) = default;
};

/// Adds a legend to a list. Merges it with a legend of the same title, unit and scale. Then entries
/// with equal names and colours become one, and their counts add up. Ignores an empty legend.
void add_legend(std::vector<Legend>& legends, Legend more);

/// Number of entries that legends_text() lists of each legend. "left_out" counts the rest.
inline constexpr std::size_t most_listed_entries = 256;

/// Returns the legends as JSON, with colours in linear RGB. It is a list of {"title", "unit"?,
/// "low"?, "high"?, "log": true?, "stops": [[r, g, b], ...]?, "entries": [{"name", "color",
/// "count"} or {"name", "arrow": true}, ...]?, "left_out"?}. Legends without a scale lack "low" to
/// "stops".
std::string legends_text(const std::vector<Legend>& legends);

}  // namespace parray::input
