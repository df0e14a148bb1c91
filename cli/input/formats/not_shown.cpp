#include "cli/input/formats/not_shown.h"

#include "common/base/text.h"

namespace parray::input {
namespace {

void note_if_any(std::string_view key, std::uint64_t count, std::string_view one,
                 std::string_view several, ParticleFacts& facts) {
  if (count == 0) return;
  facts.notes.push_back({std::string(key), count, std::string(count == 1 ? one : several)});
}

}  // namespace

void note_ellipsoids(std::uint64_t count, ParticleFacts& facts) {
  note_if_any("ellipsoids", count, "ellipsoid shown as a sphere", "ellipsoids shown as spheres",
              facts);
}

void note_bodies(std::uint64_t count, ParticleFacts& facts) {
  note_if_any("bodies", count, "line segment, triangle or body shown as a sphere",
              "line segments, triangles or bodies shown as spheres", facts);
}

void note_geometry_bonds(std::uint64_t count, ParticleFacts& facts) {
  note_if_any("geometry_bonds", count,
              "bond of the table _geom_bond not read: ParRay finds bonds by distances",
              "bonds of the table _geom_bond not read: ParRay finds bonds by distances", facts);
}

EllipsoidRows::EllipsoidRows(const std::vector<std::string_view>& names) {
  const auto x = place_in(names, "shapex");
  const auto y = place_in(names, "shapey");
  const auto z = place_in(names, "shapez");
  if (x && y && z) shape_ = {*x, *y, *z};
  oriented_ = place_in(names, "quatw").has_value();
}

void EllipsoidRows::add(const std::vector<std::string_view>& row) {
  const bool ellipsoid =
      shape_ ? is_ellipsoid(row[(*shape_)[0]], row[(*shape_)[1]], row[(*shape_)[2]]) : oriented_;
  count_ += ellipsoid ? 1 : 0;
}

bool is_ellipsoid(std::string_view x, std::string_view y, std::string_view z) {
  const auto a = number_in(x);
  const auto b = number_in(y);
  const auto c = number_in(z);
  return a && b && c && (*a != *b || *b != *c);
}

}  // namespace parray::input
