#include "cli/input/view/free_area.h"

#include <algorithm>
#include <cstddef>

namespace parray::input {
namespace {

/// The best area so far.
struct Best {
  PictureArea area{};
  double scale = 0;  ///< size of the group in this area
};

/// Tries the four sides of the area from which it can give way to each box, from box `next` on.
void search(const std::vector<PictureArea>& boxes, std::size_t next, const PictureArea& area,
            double width, double height, Best& best) {
  constexpr double least = 0.2;  // a tenth of the picture
  if (area.width() < least || area.height() < least) return;
  const double scale = std::min(area.width() / width, area.height() / height);
  const double most = best.scale * (1 + 1e-9);
  const bool larger = scale > most;
  const bool as_large = scale * (1 + 1e-9) >= best.scale;
  const auto size = [](const PictureArea& of) { return of.width() * of.height(); };
  if (!larger && !(as_large && size(area) > size(best.area))) return;
  if (next == boxes.size()) {
    best = {area, scale};
    return;
  }
  const PictureArea& box = boxes[next];
  const bool meets = box.left < area.right && box.right > area.left && box.bottom < area.top &&
                     box.top > area.bottom;
  if (!meets) return search(boxes, next + 1, area, width, height, best);
  const auto search_with = [&](double PictureArea::*side, double value) {
    PictureArea smaller = area;
    smaller.*side = value;
    search(boxes, next + 1, smaller, width, height, best);
  };
  search_with(&PictureArea::left, box.right);
  search_with(&PictureArea::right, box.left);
  search_with(&PictureArea::bottom, box.top);
  search_with(&PictureArea::top, box.bottom);
}

}  // namespace

PictureArea free_area(const LabelPlaces& labels, double width, double height) {
  const double right = std::min(filled_share, 1 - labels.margin_x);
  const double top = std::min(filled_share, 1 - labels.margin_y);
  Best best;
  search(labels.boxes, 0, {-right, right, -top, top}, width, height, best);
  if (best.scale == 0) {
    throw LabelError(
        "the labels leave too little room for the particles: use a smaller --font-size, a larger "
        "picture or fewer labels");
  }
  return best.area;
}

PictureArea scaled(const PictureArea& area, double factor) {
  const double x = (area.left + area.right) / 2;
  const double y = (area.bottom + area.top) / 2;
  const double half_width = area.width() / 2 * factor;
  const double half_height = area.height() / 2 * factor;
  return {x - half_width, x + half_width, y - half_height, y + half_height};
}

}  // namespace parray::input
