#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/math/vec.h"

namespace parray::input {

/// A colour and what it stands for.
struct LegendEntry {
  std::string name;         ///< UTF-8, as people are to read it; not empty
  Vec3d color;              ///< linear RGB in [0, 1]: the particles' albedo
  std::uint64_t count = 0;  ///< of the particles that have it

  friend bool operator==(const LegendEntry&, const LegendEntry&) = default;
};

/// What the colours of particles mean. One of these, or both:
/// - a scale of numbers: `stops` are the colours from `low` to `high` in equal steps, at least two;
///   between them colours are interpolated linearly;
/// - categories: `entries`, in the order in which people are to read them. Beside a scale they are
///   what has no place on it, such as "not known".
struct Legend {
  std::string title{};  ///< what is shown: "element", "type", "chain", a column's name
  std::string unit{};   ///< of the numbers; empty: not known, or none
  double low = 0;       ///< finite, below `high`
  double high = 0;
  std::vector<Vec3d> stops{};  ///< linear RGB in [0, 1]; empty: no scale
  std::vector<LegendEntry> entries{};

  [[nodiscard]] bool empty() const { return stops.empty() && entries.empty(); }
  friend bool operator==(const Legend&, const Legend&) = default;
};

/// Adds the legend of more particles to those that there are. Categories of the same title become
/// one list: counts of the same name and colour are added up. A scale that is there already is
/// not repeated. An empty legend adds nothing.
void add_legend(std::vector<Legend>& legends, Legend more);

/// More entries are only counted in texts.
inline constexpr std::size_t most_listed_entries = 256;

/// As JSON text: a list of {"title", "unit"?, "low", "high", "stops": [[r, g, b], ...]?,
/// "entries": [{"name", "color", "count"}, ...]?, "left_out"?}, with colours in linear RGB.
std::string legends_text(const std::vector<Legend>& legends);

}  // namespace parray::input
