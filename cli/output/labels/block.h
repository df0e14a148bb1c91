#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cli/input/color/legend.h"
#include "cli/output/labels/camera_film.h"
#include "cli/output/labels/canvas.h"

namespace parray::labels {

enum class Corner : std::uint8_t { top_left, top_right, bottom_left, bottom_right };

/// One label, before it has a place: what it takes, in pixels, and how it is drawn.
struct Block {
  std::string name;  ///< the option that asks for it, for messages: "--legend"
  Corner corner = Corner::top_left;
  double width = 0;
  double height = 0;
  /// With the block's upper left corner at that point.
  std::function<void(Pen& pen, const Point& at)> draw{};
};

/// What blocks are made with.
struct BlockStyle {
  const Font& font;  ///< must outlive the blocks
  double line;       ///< width of lines, pixels
  double room_x;     ///< pixels that there are for all blocks, without margins
  double room_y;
};

/// Lines of text.
Block text_block(const BlockStyle& style, const std::string& name, Corner corner,
                 const std::string& text);

/// The scale as a bar of its colours from the bottom up, with round numbers beside it, its title
/// above; below it, or alone, the names with their colours, in as many columns as it takes. A block
/// may be larger than the room that there is.
Block legend_block(const BlockStyle& style, const Legend& legend);

/// A bar of `length` in the scene's unit, `pixels` wide, and what it is above it. `unit` may be
/// empty.
Block scale_bar_block(const BlockStyle& style, double length, double pixels,
                      const std::string& unit);

/// The scene's x, y and z as arrows, as the camera has their directions.
Block axes_block(const BlockStyle& style, const CameraFilm& film);

/// A label that has its place.
struct Placed {
  const Block* block;
  Box box;
};

/// Gives every block a place in its corner of a picture of width x height pixels, `margin` from its
/// edges: one below the other in the upper corners, one above the other in the lower ones, in their
/// order, `gap` apart. Throws InputError, naming the option, when one does not fit: it reaches out
/// of the picture, or over another.
std::vector<Placed> lay_out(const std::vector<Block>& blocks, double width, double height,
                            double margin, double gap);

}  // namespace parray::labels
