#pragma once

#include <array>
#include <span>
#include <vector>

#include "cli/input/particles/particles.h"
#include "cli/output/labels/camera_film.h"
#include "cli/output/labels/canvas.h"

/// The outline of a box or crystal cell, hidden where something is nearer.
namespace parray::labels {

/// What tells which parts of a line are hidden, one value a pixel; empty: nothing hides.
struct DepthMap {
  std::span<const float> depth;           ///< channel "Z" (cli/output/channel_tracing.h)
  std::span<const std::uint32_t> sphere;  ///< channel "sphere"
  std::uint32_t staging =
      0;  ///< so many of the first spheres are ground and lights: they hide nothing
};

/// A part of the outline in the picture.
struct CellLine {
  Point from, to;       ///< in pixels
  double from_z, to_z;  ///< distances from the camera's plane
};

/// The twelve edges of a cell, but for what lies behind the camera.
std::vector<CellLine> cell_lines(const ParticleCell& cell, const CameraFilm& film);

/// Where its edges a, b and c are to be named: of the four that are parallel, beside the middle of
/// the outermost in the picture, away from the middle of the cell, by `gap` pixels. Edges behind
/// the camera, or seen from their ends, have no name.
struct EdgeName {
  char name;
  Point middle;
};
std::vector<EdgeName> edge_names(const ParticleCell& cell, const CameraFilm& film, double gap);

/// Draws the lines, `width` pixels wide, in an ink that stands out from what is under them.
/// `film` is that of the lines.
void draw_lines(Canvas& canvas, const std::vector<CellLine>& lines, const CameraFilm& film,
                const DepthMap& map, double width);

}  // namespace parray::labels
