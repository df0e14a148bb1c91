#include "cli/input/view/free_area.h"

#include <doctest/doctest.h>

#include <string>

#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

/// The part of a picture that labels leave free.
namespace parray {

TEST_CASE("without labels, or with labels at the edges, particles have the usual area") {
  CHECK(free_area({}, 1, 1) == usual_area);
  const LabelPlaces edges{.boxes = {{0.85, 1, -1, 1}, {-1, -0.9, 0.9, 1}}};
  CHECK(free_area(edges, 1, 1) == usual_area);
}

TEST_CASE("a label takes from the area the side that the particles need least") {
  const LabelPlaces corner{.boxes = {{0.5, 1, 0.2, 1}}};
  CHECK(free_area(corner, 0.2, 1) == PictureArea{-0.85, 0.5, -0.85, 0.85});  // a tower
  CHECK(free_area(corner, 1, 0.2) == PictureArea{-0.85, 0.85, -0.85, 0.2});  // a sheet
  const LabelPlaces left{.boxes = {{-1, -0.5, 0.2, 1}}};
  CHECK(free_area(left, 0.2, 1) == PictureArea{-0.5, 0.85, -0.85, 0.85});
}

TEST_CASE("labels in all corners leave the largest part, and no part meets a label") {
  const LabelPlaces all{
      .boxes = {{-1, -0.6, 0.8, 1}, {0.6, 1, 0, 1}, {-1, -0.7, -1, -0.6}, {0.3, 1, -1, -0.7}}};
  for (const double width : {0.1, 0.5, 1.0, 1.5}) {
    const PictureArea area = free_area(all, width, 1);
    for (const PictureArea& box : all.boxes) {
      CHECK((box.left >= area.right || box.right <= area.left || box.bottom >= area.top ||
             box.top <= area.bottom));
    }
  }
  CHECK(free_area(all, 1, 1) == PictureArea{-0.85, 0.6, -0.6, 0.8});
}

TEST_CASE("the names of a cell's edges keep a margin") {
  CHECK(free_area({.margin_x = 0.1, .margin_y = 0.3}, 1, 1) == PictureArea{-0.85, 0.85, -0.7, 0.7});
}

TEST_CASE("labels that leave no room are refused with a remedy") {
  const LabelPlaces full{.boxes = {{-1, 0.9, -1, 0.9}}};
  CHECK(test::message_of<InputError>([&] { (void)free_area(full, 1, 1); }) ==
        "the labels leave too little room for the particles: use a smaller --font-size, a larger "
        "picture or fewer labels");
}

}  // namespace parray
