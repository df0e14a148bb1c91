#include <doctest/doctest.h>

#include <vector>

#include "cli/output/postprocess/postprocessing.h"
#include "tests/support/rooms.h"

/// Several pictures in one.
namespace parray {
namespace {

ShownPicture flat_picture(std::uint32_t width, std::uint32_t height, float value) {
  ShownPicture out;
  out.image = {width, height, std::vector<float>(std::size_t{3} * width * height)};
  for (std::size_t i = 0; i < out.image.rgb.size(); ++i) {
    out.image.rgb[i] = value + static_cast<float>(i) / 4096;
  }
  return out;
}

}  // namespace

TEST_CASE("the number of columns gives the sheet a good shape") {
  const auto shape = [](std::size_t count, std::uint32_t width, std::uint32_t height) {
    const SheetLayout layout = sheet_layout(count, width, height);
    return std::pair(layout.columns, layout.rows);
  };
  CHECK(shape(1, 1200, 900) == std::pair(1U, 1U));
  CHECK(shape(2, 1200, 800) == std::pair(2U, 1U));
  CHECK(shape(3, 1200, 900) == std::pair(3U, 1U));  // no place is empty
  CHECK(shape(3, 1200, 800) == std::pair(3U, 1U));
  CHECK(shape(3, 1920, 1080) == std::pair(3U, 1U));
  CHECK(shape(4, 1200, 900) == std::pair(2U, 2U));
  CHECK(shape(6, 1200, 900) == std::pair(3U, 2U));
  CHECK(shape(3, 400, 1200) == std::pair(3U, 1U));
  CHECK(shape(3, 1600, 400) == std::pair(1U, 3U));
  CHECK(sheet_layout(2, 1200, 900).gap == 4);
  CHECK(sheet_layout(2, 10, 10).gap == 2);
}

TEST_CASE("a sheet contains every picture unchanged, with white gaps") {
  const std::vector<ShownPicture> pictures = {flat_picture(5, 4, 0), flat_picture(5, 4, 0.25F),
                                              flat_picture(5, 4, 0.5F)};
  const SheetLayout layout{.columns = 2, .rows = 2, .gap = 3};
  const Image sheet = sheet_of(pictures, layout);
  REQUIRE(sheet.width == 13);
  REQUIRE(sheet.height == 11);
  CHECK(sheet_width(layout, 5) == 13);
  CHECK(sheet_height(layout, 4) == 11);
  std::size_t of_pictures = 0;
  for (std::size_t y = 0; y < sheet.height; ++y) {
    for (std::size_t x = 0; x < sheet.width; ++x) {
      const std::size_t column = x / 8;
      const std::size_t row = y / 7;
      const std::size_t number = row * 2 + column;
      const bool inside = x % 8 < 5 && y % 7 < 4 && number < 3;
      of_pictures += inside ? 1U : 0U;
      for (std::size_t c = 0; c < 3; ++c) {
        const float expected =
            inside ? pictures[number].image.rgb[3 * (y % 7 * 5 + x % 8) + c] : 1.0F;
        CHECK(sheet.rgb[3 * (y * sheet.width + x) + c] == expected);
      }
    }
  }
  CHECK(of_pictures == 60);
}

TEST_CASE("transparent pixels are white in a sheet") {
  ShownPicture half = flat_picture(2, 2, 0);
  half.alpha = {0, 0.25F, 0.5F, 1};
  for (float& value : half.image.rgb) value = 0;
  const Image sheet = sheet_of({half}, sheet_layout(1, 2, 2));
  CHECK(sheet.rgb[0] == 1);
  CHECK(sheet.rgb[3] == 0.75F);
  CHECK(sheet.rgb[6] == 0.5F);
  CHECK(sheet.rgb[9] == 0);
}

}  // namespace parray
