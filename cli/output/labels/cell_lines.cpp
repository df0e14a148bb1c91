#include "cli/output/labels/cell_lines.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace parray::labels {
namespace {

/// Linear greys of lines: 8-bit 100 on light pictures, 170 on dark ones.
constexpr Vec3d grey_on_light{0.127, 0.127, 0.127};
constexpr Vec3d grey_on_dark{0.402, 0.402, 0.402};
/// Width and strength of lines over nearer spheres, relative to visible lines.
constexpr double hidden_share = 0.8;

enum class Part : std::uint8_t { visible, hidden };

bool hides(const DepthMap& map, std::size_t pixel, double z) {
  if (map.depth.empty() || !(static_cast<double>(map.depth[pixel]) < z)) return false;
  return map.sphere.empty() || map.sphere[pixel] >= map.scenery;
}

/// Returns the part of a line with z >= `least`. Returns nothing if there is no such part.
std::optional<std::pair<Vec3d, Vec3d>> clipped(Vec3d from, Vec3d to, double least) {
  if (from.z < least && to.z < least) return std::nullopt;
  const auto cut = [least](const Vec3d& outside, const Vec3d& inside) {
    const double share = (least - outside.z) / (inside.z - outside.z);
    return outside + share * (inside - outside);
  };
  if (from.z < least) from = cut(from, to);
  if (to.z < least) to = cut(to, from);
  return std::pair(from, to);
}

/// Returns the part of a line inside the picture, grown by `margin`. Source: Liang and Barsky, "A
/// New Concept and Method for Line Clipping", ACM Transactions on Graphics 3 (1984) 1.
std::optional<std::pair<double, double>> part_inside(const CellLine& line, const Canvas& canvas,
                                                     double margin) {
  double begin = 0;
  double end = 1;
  const auto keep = [&](double start, double change, double least, double most) {
    if (change == 0) return start >= least && start <= most;
    const double a = (least - start) / change;
    const double b = (most - start) / change;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
    return begin < end;
  };
  const bool some = keep(line.from.x, line.to.x - line.from.x, -margin, canvas.width() + margin) &&
                    keep(line.from.y, line.to.y - line.from.y, -margin, canvas.height() + margin);
  return some ? std::optional(std::pair(begin, end)) : std::nullopt;
}

/// Returns z at a share of the way in the picture. With perspective, 1 / z is linear there.
double depth_at(const CellLine& line, double share, bool perspective) {
  if (!perspective) return line.from_z + share * (line.to_z - line.from_z);
  return 1 / ((1 - share) / line.from_z + share / line.to_z);
}

/// Calls visit(x, y, share) for every pixel of the picture in which the line, `width` pixels wide,
/// covers a share and is visible or hidden, as `wanted` says.
void each_pixel(const Canvas& canvas, const CellLine& line, bool perspective, const DepthMap& map,
                double width, Part wanted, const auto& visit) {
  const double reach = width / 2 + 1;
  const auto inside = part_inside(line, canvas, reach);
  const double dx = line.to.x - line.from.x;
  const double dy = line.to.y - line.from.y;
  const double length = std::hypot(dx, dy);
  if (!inside || !(length > 0)) return;
  const bool flat =
      std::abs(dx) >= std::abs(dy);  // true: one column per step; false: one row per step
  const double slope = flat ? dy / dx : dx / dy;
  const auto major = [&](double share) {
    return flat ? line.from.x + share * dx : line.from.y + share * dy;
  };
  const auto [low, high] = std::minmax({major(inside->first), major(inside->second)});
  const double across = reach * std::hypot(1, slope);
  const auto picture_width = static_cast<int>(canvas.width());
  const auto picture_height = static_cast<int>(canvas.height());
  for (int i = static_cast<int>(std::floor(low - reach)); i <= std::ceil(high + reach); ++i) {
    const double start = flat ? line.from.x : line.from.y;
    const double middle = (flat ? line.from.y : line.from.x) + slope * (i + 0.5 - start);
    for (int j = static_cast<int>(std::floor(middle - across)); j <= std::ceil(middle + across);
         ++j) {
      const int x = flat ? i : j;
      const int y = flat ? j : i;
      if (x < 0 || y < 0 || x >= picture_width || y >= picture_height) continue;
      const double px = x + 0.5 - line.from.x;
      const double py = y + 0.5 - line.from.y;
      const double along = (px * dx + py * dy) / length;
      const double ends = std::clamp(std::min(along, length - along) + width / 2 + 0.5, 0.0, 1.0);
      const double share = ends * line_share(std::abs(px * dy - py * dx) / length, width);
      const double z = depth_at(line, std::clamp(along / length, 0.0, 1.0), perspective);
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_width) +
          static_cast<std::size_t>(x);
      const Part part = hides(map, pixel, z) ? Part::hidden : Part::visible;
      if (share > 0 && part == wanted) visit(x, y, share);
    }
  }
}

Vec3d corner(const ParticleCell& cell, unsigned bits) {
  Vec3d at = cell.origin;
  for (std::size_t edge = 0; edge < 3; ++edge) {
    if ((bits >> edge & 1U) != 0) at = at + cell.edges[edge];
  }
  return at;
}

std::optional<CellLine> line_between(const Vec3d& from, const Vec3d& to, const CameraFilm& film) {
  // Parts nearer than this are cut off, because their projection would be almost infinitely far
  // away.
  const double least = film.perspective() ? 1e-3 * film.distance() : -1e300;
  const auto part = clipped(film.seen(from), film.seen(to), least);
  if (!part) return std::nullopt;
  return CellLine{film.shown(part->first), film.shown(part->second), part->first.z, part->second.z};
}

/// Returns whether the picture below the lines is light on average.
bool is_light_below(const Canvas& canvas, const std::vector<CellLine>& lines, bool perspective,
                    const DepthMap& map, double width) {
  double sum = 0;
  double count = 0;
  for (const CellLine& line : lines) {
    each_pixel(canvas, line, perspective, map, width, Part::visible,
               [&](int x, int y, double /*share*/) {
                 sum += std::cbrt(canvas.luminance(x, y));
                 ++count;
               });
  }
  return count == 0 || sum / count > light_background;
}

}  // namespace

std::vector<CellLine> cell_lines(const ParticleCell& cell, const CameraFilm& film) {
  unsigned farthest = 0;
  const auto depth = [&](unsigned bits) { return film.seen(corner(cell, bits)).z; };
  for (unsigned bits = 1; bits < 8; ++bits) {
    if (depth(bits) > depth(farthest)) farthest = bits;
  }
  std::vector<CellLine> lines;
  for (unsigned from = 0; from < 8; ++from) {
    for (const unsigned edge : {1U, 2U, 4U}) {
      if ((from & edge) != 0) continue;
      auto line = line_between(corner(cell, from), corner(cell, from | edge), film);
      if (!line) continue;
      line->behind = from == farthest || (from | edge) == farthest;
      lines.push_back(*line);
    }
  }
  return lines;
}

std::vector<EdgeName> edge_names(const ParticleCell& cell, const CameraFilm& film, double gap) {
  const Vec3d middle = film.seen(0.5 * (corner(cell, 0) + corner(cell, 7)));
  std::vector<EdgeName> names;
  if (film.perspective() && middle.z <= 0) return names;
  const Point center = film.shown(middle);
  for (unsigned edge = 0; edge < 3; ++edge) {
    std::optional<EdgeName> best;
    double outermost = 0;
    for (unsigned from = 0; from < 8; ++from) {
      if ((from >> edge & 1U) != 0) continue;
      const auto line = line_between(corner(cell, from), corner(cell, from | 1U << edge), film);
      if (!line) continue;
      const Point along = line->to - line->from;
      const double length = std::hypot(along.x, along.y);
      if (length < 2 * gap) continue;
      const Point half{(line->from.x + line->to.x) / 2, (line->from.y + line->to.y) / 2};
      const Point side{-along.y / length, along.x / length};
      const double outwards = side.x * (half.x - center.x) + side.y * (half.y - center.y);
      if (std::abs(outwards) <= outermost) continue;
      outermost = std::abs(outwards);
      const Point away = (outwards < 0 ? -1.0 : 1.0) * side;
      best = {static_cast<char>('a' + edge), half + gap * away, away};
    }
    if (best) names.push_back(*best);
  }
  return names;
}

void draw_lines(Canvas& canvas, const std::vector<CellLine>& lines, const CameraFilm& film,
                const DepthMap& map, double width) {
  const bool perspective = film.perspective();
  const bool light = is_light_below(canvas, lines, perspective, map, width);
  const Vec3d color = light ? grey_on_light : grey_on_dark;
  const auto draw = [&](const CellLine& line, Part part, double share) {
    each_pixel(canvas, line, perspective, map, share * width, part,
               [&](int x, int y, double covered) { canvas.paint(x, y, color, share * covered); });
  };
  for (const CellLine& line : lines) {
    draw(line, Part::visible, 1);
    if (!line.behind) draw(line, Part::hidden, hidden_share);
  }
}

}  // namespace parray::labels
