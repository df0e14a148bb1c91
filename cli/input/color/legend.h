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
  Vec3d color;              ///< linear RGB in [0, 1]: the particles' albedo
  std::uint64_t count = 0;  ///< number of particles with this colour

  friend bool operator==(const LegendEntry&, const LegendEntry&) = default;
};

/// The meaning of particles' colours: one of these, or both.
/// - A scale of numbers: `stops` are the colours from `low` to `high` in equal steps, at least two,
///   with linear interpolation between them.
/// - Categories: `entries`, in reading order. Beside a scale they explain colours outside the
///   scale, such as "not known".
struct Legend {
  std::string title{};  ///< "element", "type", "chain" or a column's name
  std::string unit{};   ///< of the numbers; empty: unknown or none
  double low = 0;       ///< finite, below `high`
  double high = 0;
  std::vector<Vec3d> stops{};  ///< linear RGB in [0, 1]; empty: no scale
  std::vector<LegendEntry> entries{};

  [[nodiscard]] bool empty() const { return stops.empty() && entries.empty(); }
  friend bool operator==(const Legend&, const Legend&) = default;
};

/// Adds a legend to others. Legends of the same title become one list, which adds up counts of
/// equal names and colours. Equal scales appear once. An empty legend adds nothing.
void add_legend(std::vector<Legend>& legends, Legend more);

/// Texts list so many entries and count the rest.
inline constexpr std::size_t most_listed_entries = 256;

/// Returns the legends as JSON: a list of {"title", "unit"?, "low", "high", "stops": [[r, g, b],
/// ...]?, "entries": [{"name", "color", "count"}, ...]?, "left_out"?}, with colours in linear RGB.
std::string legends_text(const std::vector<Legend>& legends);

}  // namespace parray::input
