#include "cli/output/labels/font.h"

#include <doctest/doctest.h>
#include <ft2build.h>
#include FT_FREETYPE_H

#include <cmath>
#include <string>

#include "cli/output/labels/canvas.h"
#include "common/base/error.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::message_of;

double drawn_area(const Font& font, const std::string& text, const Point& at) {
  Coverage coverage(Box{0, 0, 400, 60});
  font.draw(coverage, at, text);
  return coverage.area();
}

}  // namespace

TEST_CASE("the width of a text follows from the font's advances at any size") {
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  REQUIRE(FT_Init_FreeType(&library) == 0);
  REQUIRE(FT_New_Face(library, label_font().c_str(), 0, &face) == 0);
  double units = 0;
  for (const char letter : std::string("H 0123")) {  // pairs without kerning
    REQUIRE(FT_Load_Char(face, static_cast<FT_ULong>(letter), FT_LOAD_NO_SCALE) == 0);
    units += static_cast<double>(face->glyph->advance.x);
  }
  for (const double size : {7.3, 12.0, 33.333, 200.0}) {
    const Font font(size);
    CHECK(font.width("H 0123") ==
          doctest::Approx(units * std::round(size * 64) / 64 / face->units_per_EM).epsilon(1e-3));
  }
  FT_Done_Face(face);
  FT_Done_FreeType(library);
  const Font font(30);
  CHECK(font.width("AV") < font.width("A") + font.width("V") - 1);  // kerning
}

TEST_CASE(
    "letters cover the same area wherever a text begins, and four times it at twice the size") {
  const Font font(20);
  const double area = drawn_area(font, "a\u00c5\u03b1", {10, 30});
  CHECK(area > 100);
  for (const Point at : {Point{10.25, 30}, {10.5, 30.5}, {200.75, 41.1}}) {
    CHECK(drawn_area(font, "a\u00c5\u03b1", at) == doctest::Approx(area).epsilon(0.01));
  }
  const Font large(40);
  CHECK(drawn_area(large, "a\u00c5\u03b1", {10, 45}) == doctest::Approx(4 * area).epsilon(0.02));
  CHECK(drawn_area(font, "  ", {10, 30}) == 0);
}

TEST_CASE("a letter lies between its baseline and its cap height") {
  const Font font(30);
  Coverage coverage(Box{0, 0, 60, 60});
  font.draw(coverage, {10, 40}, "H");
  const auto row_is_empty = [&](int y) {
    for (int x = 0; x < 60; ++x) {
      if (coverage.at(x, y) > 0) return false;
    }
    return true;
  };
  const int top = static_cast<int>(std::floor(40 - font.cap_height()));
  CHECK(row_is_empty(40));
  CHECK_FALSE(row_is_empty(39));
  CHECK_FALSE(row_is_empty(top));
  CHECK(row_is_empty(top - 1));
}

TEST_CASE("a missing font is reported in one line with its package") {
  CHECK(message_of<RunError>([] { Font(10, "/nowhere/DejaVuSans.ttf"); })
            .starts_with("/nowhere/DejaVuSans.ttf: the font of labels, DejaVu Sans, is missing: "
                         "install fonts-dejavu-core, or copy the font to /"));
  CHECK(message_of<RunError>([] { Font(10, "/etc/passwd"); }) ==
        "/etc/passwd: the font of labels cannot be read: install again what contains the file: "
        "fonts-dejavu-core, or ParRay");
}

TEST_CASE("invalid texts are refused: not UTF-8, control characters, letters that the font lacks") {
  const Font font(10);
  font.check("Caf\u00e9 \u03b1 \u2212 10\u207b\u00b3", "--text");
  const auto problem = [&](const std::string& text) {
    return message_of<InputError>([&] { font.check(text, "--text"); });
  };
  CHECK(problem("a\u4e2d") ==
        "--text: the font DejaVu Sans has no character U+4E2D: use another character");
  CHECK(problem("a\tb") ==
        "--text: the font DejaVu Sans has no character U+0009: use another character");
  for (const std::string bad : {"\xff", "\xc3", "\xc0\x80", "\xed\xa0\x80", "\xf5\x80\x80\x80"}) {
    CHECK(problem(bad) ==
          "--text: the text is not UTF-8: use a terminal or a script with that encoding");
  }
  CHECK(font.width("\xff") == font.width("\ufffd"));  // of a name in a file
}

}  // namespace parray
