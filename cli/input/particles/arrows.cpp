#include "cli/input/particles/arrows.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "cli/input/particles/beads.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/scene_file/label_settings.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

using Columns = std::array<std::string, 3>;

// Proportions of an arrow, in radii of the shaft:
constexpr double head_length = 6.5;   ///< from the centre of the largest ball to the tip
constexpr double head_radius = 2.3;   ///< of the largest ball
constexpr double least_length = 12;   ///< of an arrow of full width
constexpr double shrink = 0.9;        ///< radius of a ball relative to the previous ball
constexpr int balls_of_head = 20;     ///< the last one is thinner than a third of the shaft
constexpr double width_share = 0.05;  ///< width of an arrow in distances of neighbours

/// Returns the three columns of a list of columns. Returns nothing for other texts.
std::optional<Columns> listed(std::string_view arrows) {
  const std::vector<std::string_view> parts = split_at(',', arrows);
  if (std::ranges::count(arrows, ',') != 2 || parts.size() != 3) return {};
  Columns columns;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    columns.at(i) = lower_case(trimmed(parts[i]));
    if (columns.at(i).empty()) return {};
  }
  return columns;
}

/// Returns the columns that may hold the vectors, the usual ones first.
std::vector<Columns> candidates(std::string_view arrows) {
  if (const auto columns = listed(arrows)) return {*columns};
  std::vector<std::string> names{std::string(arrows)};
  if (arrows == "velocity") names = {"v", "velocity", "velocities", "velo", "vel"};
  if (arrows == "force") names = {"f", "force", "forces"};
  std::vector<Columns> all;
  for (const std::string& name : names) {
    all.push_back({name + "x", name + "y", name + "z"});
    all.push_back({name + "_x", name + "_y", name + "_z"});
    all.push_back({name + ":0", name + ":1", name + ":2"});  // ParaView
  }
  return all;
}

/// Returns the columns of the vectors. Throws UnknownNumber if the particles lack them.
std::array<const NumberColumn*, 3> columns_in(const Particles& particles, std::string_view arrows) {
  const std::vector<Columns> all = candidates(arrows);
  for (const Columns& names : all) {
    const std::array columns{particles.numbers_named(names[0]), particles.numbers_named(names[1]),
                             particles.numbers_named(names[2])};
    if (std::ranges::count(columns, nullptr) == 0) return columns;
  }
  for (const std::string& name : all.front()) {
    if (particles.numbers_named(name) == nullptr) throw UnknownNumber(name);
  }
  return {};
}

/// Returns the vectors, 0 for unknown ones. Adds a note that counts these.
std::vector<Vec3d> vectors_of(const std::array<const NumberColumn*, 3>& columns,
                              Particles& particles) {
  std::vector<Vec3d> vectors(particles.count());
  std::uint64_t unknown = 0;
  for (std::size_t i = 0; i < vectors.size(); ++i) {
    const Vec3d v{columns[0]->values[i], columns[1]->values[i], columns[2]->values[i]};
    const bool known = std::isfinite(dot(v, v));
    if (known) vectors[i] = v;
    unknown += known ? 0 : 1;
  }
  particles.facts.note("unknown_vectors", unknown,
                       particles_word(unknown) + " without a known vector, drawn without an arrow");
  return vectors;
}

std::string with_three_digits(double value) {
  std::array<char, 32> text{};
  const auto end =
      std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::general, 3);
  return {text.data(), end.ptr};
}

Legend legend_of(std::string_view arrows, const NumberColumn& column, double longest) {
  const std::size_t end = column.unit.find('/');  // "angstrom/ps"
  std::string unit(unit_sign(std::string_view(column.unit).substr(0, end)));
  if (end != std::string::npos) unit += column.unit.substr(end);
  const std::string text = "longest = " + with_three_digits(longest);
  Legend legend{.title = std::string(arrows)};
  legend.entries.push_back({.name = text + (unit.empty() ? "" : " " + unit), .arrow = true});
  return legend;
}

}  // namespace

std::string arrows_from(std::string_view text) {
  std::string arrows = lower_case(trimmed(text));
  if (!arrows.empty() && (arrows.find(',') == std::string::npos || listed(arrows))) return arrows;
  throw InputError("'" + printable(text) +
                   "' names no vector: write velocity, force, the name of a vector, or three "
                   "columns such as vx,vy,vz");
}

std::set<std::string, std::less<>> numbers_of_arrows(std::string_view arrows) {
  std::set<std::string, std::less<>> numbers;
  if (arrows.empty()) return numbers;
  for (const Columns& columns : candidates(arrows)) numbers.insert(columns.begin(), columns.end());
  return numbers;
}

void ArrowMeasure::add(const ArrowMeasure& frame) {
  longest = std::max(longest, frame.longest);
  if (spacing == 0) spacing = frame.spacing;
}

ParticleArrows arrows_of(std::string_view arrows, const std::optional<double>& scale,
                         Particles& particles, const std::optional<ArrowMeasure>& measure) {
  const std::array<const NumberColumn*, 3> columns = columns_in(particles, arrows);
  ParticleArrows out{vectors_of(columns, particles), 0, {}, {}};
  out.measure.spacing = typical_distance(particles.positions);
  for (const Vec3d& vector : out.arrows) {
    out.measure.longest = std::max(out.measure.longest, length(vector));
  }
  const auto [longest, spacing] = measure.value_or(out.measure);
  if (longest == 0) return out;
  if (!scale && spacing == 0) {
    throw SourceError("arrow_scale",
                      "the particles have no neighbours that give arrows a length: "
                      "write the length of the arrow of a vector of length 1");
  }
  const double factor = scale ? *scale : longest_arrow * spacing / longest;
  if (!(factor * longest <= limits::max_length)) {
    throw SourceError("arrow_scale", "the longest vector is " + number_text(longest) +
                                         ", so its arrow would be longer than 1e15: use a smaller "
                                         "scale");
  }
  for (Vec3d& vector : out.arrows) vector = factor * vector;
  out.width = spacing > 0 ? width_share * spacing : factor * longest / least_length;
  out.legend = legend_of(arrows, *columns[0], longest);
  return out;
}

void append_arrow(const Vec3d& center, const Vec3d& arrow, double width, std::uint32_t material,
                  std::vector<Capsule>& capsules) {
  const double size = length(arrow);
  const double shaft = std::min(width, size / least_length);
  constexpr double tip_radius = 0.01;  // in radii of the shaft: the balls are not points
  if (!(shaft * tip_radius >= limits::min_radius)) return;
  const Vec3d along = (1 / size) * arrow;
  const auto at = [&](double distance) { return center + distance * along; };
  const double base = size - head_length * shaft;
  capsules.push_back({at(0), at(base), shaft, material});
  double radius = head_radius;
  for (int i = 0; i < balls_of_head; ++i, radius *= shrink) {
    const double left = head_length * radius / head_radius;  // to the tip
    const Vec3d middle = at(size - left * shaft);
    capsules.push_back({middle, middle, radius * shaft, material});
  }
}

}  // namespace parray::input
