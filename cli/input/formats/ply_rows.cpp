#include "cli/input/formats/ply_rows.h"

#include <algorithm>

#include "cli/input/formats/ply_value.h"
#include "cli/input/particles/srgb8.h"
#include "common/scene/limits.h"

namespace parray::input {

PlyRows::PlyRows(const PlyElement& vertex, const RowLayout& layout, bool swapped)
    : vertex_(vertex), layout_(layout), swapped_(swapped) {
  for (const PlyProperty& property : vertex.properties) {
    offsets_.push_back(row_bytes_);
    row_bytes_ += size_of(property.type);
  }
}

template <typename Put>
bool PlyRows::read_property(std::size_t property, const char* rows, std::size_t count, double least,
                            double most, const Put& put) const {
  const char* const from = rows + offsets_[property];
  return with_ply_type(vertex_.properties[property].type, [&](auto type) {
    bool good = true;
    for (std::size_t i = 0; i < count; ++i) {
      const double value = ply_value<decltype(type)>(from + i * row_bytes_, swapped_);
      good = good && value >= least && value <= most;  // false for NaN
      put(i, value);
    }
    return good;
  });
}

bool PlyRows::read_vectors(const std::array<std::size_t, 3>& properties, const char* rows,
                           std::size_t count, double least, double most, Vec3d* to) const {
  const bool x = read_property(properties[0], rows, count, least, most,
                               [to](std::size_t i, double value) { to[i].x = value; });
  const bool y = read_property(properties[1], rows, count, least, most,
                               [to](std::size_t i, double value) { to[i].y = value; });
  const bool z = read_property(properties[2], rows, count, least, most,
                               [to](std::size_t i, double value) { to[i].z = value; });
  return x && y && z;
}

bool PlyRows::read(const char* rows, std::size_t count, Particles& out, std::size_t first) const {
  constexpr std::size_t at_once = 512;  // property by property, while they are in the cache
  bool good = true;
  for (std::size_t done = 0; good && done < count; done += at_once) {
    const char* const from = rows + done * row_bytes_;
    const std::size_t at = first + done;
    const std::size_t some = std::min(at_once, count - done);
    good = read_vectors(layout_.position, from, some, -limits::max_length, limits::max_length,
                        &out.positions[at]);
    if (layout_.radius) {
      good =
          good && read_property(*layout_.radius, from, some, limits::min_radius, limits::max_length,
                                [&](std::size_t i, double value) { out.radii[at + i] = value; });
    }
    for (std::size_t n = 0; n < layout_.numbers.size(); ++n) {
      double* const to = out.numbers[n].values.data() + at;
      read_property(layout_.numbers[n].column, from, some, 0, 0,
                    [to](std::size_t i, double value) { to[i] = value; });
    }
    if (!layout_.color) continue;
    const bool whole = layout_.color_scale == ColorScale::srgb8;
    good = good && read_vectors(*layout_.color, from, some, 0, whole ? 255 : 1, &out.colors[at]);
    for (std::size_t i = 0; whole && good && i < some; ++i) {
      out.colors[at + i] = linear_of_srgb8(out.colors[at + i]);
    }
  }
  return good;
}

}  // namespace parray::input
