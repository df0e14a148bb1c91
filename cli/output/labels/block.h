#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/output/labels/camera_film.h"
#include "cli/output/labels/canvas.h"

namespace parray::labels {

/// A corner of the picture.
enum class Corner : std::uint8_t { top_left, top_right, bottom_left, bottom_right };

/// A label before it has a place: its size in pixels, and how to draw it.
struct Block {
  std::string name;  ///< the option that requests it, for messages: "--legend"
  Corner corner = Corner::top_left;
  double width = 0;
  double height = 0;
  /// Draws the block with its upper left corner at `at`.
  std::function<void(Pen& pen, const Point& at)> draw{};
};

/// What all blocks of a picture share.
struct BlockStyle {
  const Font& font;  ///< must outlive the blocks
  double line;       ///< width of lines, pixels
  double room_y;     ///< height of the picture minus both margins, in pixels
};

/// Returns a block with the lines of `text`. `name`: see Block.
Block text_block(const BlockStyle& style, const std::string& name, Corner corner,
                 const std::string& text);

/// Returns a legend. The scale is a vertical bar with the lowest value at the bottom, round numbers
/// beside it and the title above. Names with their colours are below the bar, or alone, in as many
/// columns as necessary. The block may be larger than the available space.
Block legend_block(const BlockStyle& style, const Legend& legend);

inline constexpr const char* scale_bar_name = "--scale-bar";  ///< name of its block

/// Returns a scale bar that stands for `length` in `unit` and is `pixels` wide, with the length as
/// text above it. `unit` may be empty.
Block scale_bar_block(const BlockStyle& style, double length, double pixels,
                      const std::string& unit);

/// Returns the scene's axes x, y and z as arrows in the directions that the camera sees.
Block axes_block(const BlockStyle& style, const CameraFilm& film);

/// A label with its place.
struct Placed {
  const Block* block;  ///< refers to the argument of lay_out()
  Box box;
};

/// Returns whether two boxes have a common area.
bool overlap(const Box& a, const Box& b);

/// Places every block in its corner of a picture of width x height pixels. Blocks are `margin`
/// pixels away from the edges and `gap` pixels apart. `blocks` must outlive the result. If a corner
/// has several blocks, the first is nearest to the edge, and the others follow below it (upper
/// corners) or above it (lower corners). Throws InputError, which names the option, if a block does
/// not fit inside the margins, or is nearer than gap / 2 to a block of another corner.
std::vector<Placed> lay_out(const std::vector<Block>& blocks, double width, double height,
                            double margin, double gap);

}  // namespace parray::labels
