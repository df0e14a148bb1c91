#pragma once

#include <span>
#include <vector>

#include "cli/input/particles/particles.h"
#include "cli/output/labels/camera_film.h"
#include "cli/output/labels/canvas.h"

/// The outline of a box or crystal cell: thin grey lines.
namespace parray::labels {

/// What hides parts of a line, one value per pixel. Empty: nothing hides it. Refers to the
/// channels.
struct DepthMap {
  std::span<const float> depth;           ///< channel "Z" (cli/output/channel_tracing.h)
  std::span<const std::uint32_t> sphere;  ///< channel "sphere"
  /// Number of first spheres that are ground and lights. These hide nothing.
  std::uint32_t scenery = 0;
};

/// A part of the outline.
struct CellLine {
  Point from, to;       ///< in pixels
  double from_z, to_z;  ///< distances from the camera's plane
  bool behind = false;  ///< the edge ends at the farthest corner: the cell itself is before it
};

/// Returns the twelve edges of a cell, without the parts behind the camera.
std::vector<CellLine> cell_lines(const ParticleCell& cell, const CameraFilm& film);

/// The name of an edge of a cell.
struct EdgeName {
  char name;       ///< 'a', 'b' or 'c'
  Point middle;    ///< of the name
  Point outwards;  ///< unit vector away from the cell
};
/// Returns the places of the names of edges a, b and c. Among four parallel edges, the outermost
/// in the picture gets the name. The name is beside the middle of the edge, `gap` pixels away, on
/// the side away from the cell. Edges behind the camera, or shorter than 2 * `gap` in the picture,
/// have no name. No edge has a name if the middle of the cell is behind the camera.
std::vector<EdgeName> edge_names(const ParticleCell& cell, const CameraFilm& film, double gap);

/// Draws the lines, `width` pixels wide, in a grey that contrasts with the picture below. Nearer
/// shapes hide the edges behind the cell (CellLine::behind). The other edges are drawn over nearer
/// shapes, too, but thinner and fainter. Otherwise the atoms on the faces of a cell would make
/// dashes of its outline. `film`: the one with which `lines` were made.
void draw_lines(Canvas& canvas, const std::vector<CellLine>& lines, const CameraFilm& film,
                const DepthMap& map, double width);

}  // namespace parray::labels
