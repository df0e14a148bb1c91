// What is drawn on a picture after it was traced: places, lengths, lines, colours.
#include "cli/output/labels/labels.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <vector>

#include "cli/output/labels/block.h"
#include "cli/output/labels/round_numbers.h"
#include "common/base/error.h"
#include "common/scene/settings.h"
#include "tests/support/message_of.h"
#include "tests/support/rooms.h"

namespace parray {
namespace {

using test::message_of;

Image grey(std::uint32_t width, std::uint32_t height, float value) {
  return {width, height, std::vector<float>(std::size_t{3} * width * height, value)};
}

/// Of the first channel, pixels other than `background`.
std::size_t changed(const Image& image, float background) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.rgb.size(); i += 3) count += image.rgb[i] != background ? 1 : 0;
  return count;
}

Camera camera_of(double vfov) {
  Camera camera;
  camera.look_from = {0, 0, 10};
  camera.look_at = {0, 0, 0};
  camera.up = {0, 1, 0};
  camera.vfov = vfov;
  camera.tan_half_vfov = std::tan(vfov / 2 * (std::numbers::pi / 180));
  camera.aperture = 0;
  return camera;
}

LabelContent content_of(std::uint32_t width, std::uint32_t height) {
  LabelContent content;
  content.camera = camera_of(40);
  content.width = width;
  content.height = height;
  return content;
}

Legend elements(std::size_t count) {
  Legend legend{.title = "element"};
  for (std::size_t i = 0; i < count; ++i) {
    legend.entries.push_back({"name " + std::to_string(i), {0.5, 0.1, 0.1}, 1});
  }
  return legend;
}

const Legend velocity{
    .title = "vx", .unit = "\u00c5/ps", .low = -1, .high = 1, .stops = {{0, 0, 1}, {1, 0, 0}}};

std::string refusal(const LabelContent& content) {
  return message_of<InputError>([&] { Labels{content}; });
}

/// First and last column in which the row has that value.
std::pair<int, int> extent(const Image& image, std::uint32_t row, float value) {
  int first = -1;
  int last = -1;
  for (std::uint32_t x = 0; x < image.width; ++x) {
    if (image.rgb[3 * (std::size_t{row} * image.width + x)] != value) continue;
    if (first < 0) first = static_cast<int>(x);
    last = static_cast<int>(x);
  }
  return {first, last};
}

}  // namespace

// ---- Places ------------------------------------------------------------------------------------

TEST_CASE("labels at the margin fit despite rounding of their widths") {
  for (int i = 1; i <= 1000; ++i) {
    const Block block{"--text", Corner::bottom_right, 0.37 * i / 3, 0.29 * i / 7, {}};
    CHECK_NOTHROW(lay_out({block}, 1200.1, 900.3, 0.1 * i / 9, 8));
  }
}

TEST_CASE("labels in all corners are inside the picture and do not overlap") {
  const Font font(14);
  const BlockStyle style{font, 1, 580};
  std::vector<Block> blocks = {
      text_block(style, "--text", Corner::top_left, "A title\nof two lines"),
      text_block(style, "--time-stamp", Corner::top_left, "frame 3"),
      legend_block(style, velocity),
      legend_block(style, elements(5)),
      scale_bar_block(style, 20, 150, "nm"),
      axes_block(style, CameraFilm(camera_of(40), 800, 600))};
  const std::vector<Placed> placed = lay_out(blocks, 800, 600, 10, 8);
  REQUIRE(placed.size() == blocks.size());
  for (const Placed& one : placed) {
    CHECK(one.box.x >= 10);
    CHECK(one.box.y >= 10);
    CHECK(one.box.x + one.box.width <= 790 + 1e-9);
    CHECK(one.box.y + one.box.height <= 590 + 1e-9);
    for (const Placed& other : placed) {
      const bool apart =
          one.box.x + one.box.width <= other.box.x || other.box.x + other.box.width <= one.box.x ||
          one.box.y + one.box.height <= other.box.y || other.box.y + other.box.height <= one.box.y;
      CHECK((apart || one.block == other.block));
    }
  }
}

TEST_CASE("a label draws only inside its box, except for its halo") {
  const Font font(20);
  const BlockStyle style{font, 1.5, 380};
  for (const Block& block :
       {text_block(style, "--text", Corner::top_left, "gjpq\u00c5H"), legend_block(style, velocity),
        legend_block(style, elements(40)), scale_bar_block(style, 2e-9, 100, "m"),
        axes_block(style, CameraFilm(camera_of(40), 400, 400))}) {
    CAPTURE(block.name);
    Image image = grey(800, 800, 1);
    std::vector<float> opaque;
    Canvas canvas(image, opaque);
    const Box box{50, 50, block.width, block.height};
    Pen pen(font, style.line, box);
    block.draw(pen, {box.x, box.y});
    pen.draw_on(canvas);
    CHECK(changed(image, 1) > 50);
    const Box around = box.grown(2.5);  // accents reach above capitals
    for (std::uint32_t y = 0; y < 800; ++y) {
      for (std::uint32_t x = 0; x < 800; ++x) {
        const bool inside = x + 1 > around.x && x < around.x + around.width && y + 5 > around.y &&
                            y < around.y + around.height;
        if (!inside && image.rgb[3 * (800 * y + x)] != 1) FAIL_CHECK("at ", x, ", ", y);
      }
    }
  }
}

TEST_CASE("a legend of many names gets columns, and one that does not fit is refused in one line") {
  LabelContent content = content_of(600, 300);
  content.settings.legend = true;
  content.settings.dpi = 96;
  content.legends = {elements(20)};
  static_cast<void>(Labels{content});  // it fits
  content.legends = {elements(500)};
  CHECK(refusal(content) ==
        "--legend: the label does not fit into 600 x 300 pixels: use a smaller --font-size, or "
        "leave out --legend, or legend in the scene file");
  content.legends = {elements(14)};
  content.settings.text = std::string(50, 'm');
  CHECK(refusal(content).starts_with(
      "--legend: the label does not fit into 600 x 300 pixels beside --text"));
}

TEST_CASE("a label without content in the scene is refused before any work") {
  LabelContent content = content_of(600, 400);
  content.settings.legend = true;
  CHECK(refusal(content).starts_with("--legend: the scene has no colours to explain"));
  content.settings = {.time_stamp = true};
  CHECK(refusal(content).starts_with("--time-stamp: "));
  content.settings = {.cell = true};
  CHECK(refusal(content).starts_with("--cell: the scene's particles have no box"));
  content.settings = {.text = "a", .font_size = 200, .dpi = 10000};
  CHECK(refusal(content) ==
        "--font-size: letters of 200 points are 27778 pixels high, but the picture only 400: use a "
        "smaller --font-size");
  content.settings = {.scale_bar = true, .unit = "\u4e2d"};
  CHECK(refusal(content).starts_with("--unit: the font DejaVu Sans has no character U+4E2D"));
}

// ---- Lengths -----------------------------------------------------------------------------------

TEST_CASE("a scale bar is as long as the camera shows that length at look_at, to the pixel") {
  LabelContent content = content_of(800, 600);
  content.settings = {.scale_bar = true, .unit = "angstrom"};
  const CameraFilm film(content.camera, 800, 600);
  const double length = round_below(200 / film.pixels_per_unit(10));
  // Two points so far apart, in the plane through look_at.
  const Point left = film.shown(film.seen({-length / 2, 0, 0}));
  const Point right = film.shown(film.seen({length / 2, 0, 0}));
  const double pixels = right.x - left.x;
  CHECK(pixels <= 200);
  CHECK(pixels > 80);
  Image image = grey(800, 600, 1);
  std::vector<float> opaque;
  Labels{content}.draw(image, opaque, {});
  const double em = 8 * dots_per_inch(content.settings, 800) / 72;
  const auto bar_row = static_cast<std::uint32_t>(600 - 0.8 * em - 0.125 * em);
  const auto [first, last] = extent(image, bar_row, 0);
  CHECK(last + 1 - first == doctest::Approx(pixels).epsilon(2 / pixels));
  const double sum = std::accumulate(
      image.rgb.begin() + std::ptrdiff_t{3} * 800 * bar_row,
      image.rgb.begin() + std::ptrdiff_t{3} * 800 * (bar_row + 1), 0.0,
      [](double total, float value) { return total + 1 - static_cast<double>(value); });
  CHECK(sum / 3 == doctest::Approx(pixels).epsilon(1e-4));  // halos are as white as the picture
}

TEST_CASE("a scale bar has a unit that needs few digits") {
  const auto drawn = [](double scale, const std::string& unit) {
    LabelContent content = content_of(800, 600);
    content.camera.look_from.z *= scale;
    content.settings.scale_bar = true;
    content.unit = unit;
    Image image = grey(800, 600, 1);
    std::vector<float> opaque;
    Labels{content}.draw(image, opaque, {});
    return image.rgb;
  };
  CHECK(drawn(0.01, "m") == drawn(10, "mm"));
  CHECK(drawn(0.01, "m") != drawn(0.01, ""));
  CHECK(drawn(1e4, "pc") == drawn(10, "kpc"));
  CHECK(drawn(1e4, "angstrom") != drawn(1e3, "nm"));
}

TEST_CASE("an orthographic camera shows a length with the same number of pixels anywhere") {
  Camera camera = camera_of(40);
  camera.projection = Projection::orthographic;
  camera.vfov = camera.tan_half_vfov = 0;
  camera.view_height = 12;
  const CameraFilm film(camera, 800, 600);
  for (const double z : {-3.0, 0.0, 7.0}) {
    const Point left = film.shown(film.seen({-2, 1, z}));
    const Point right = film.shown(film.seen({2, 1, z}));
    CHECK(right.x - left.x == doctest::Approx(4 * 50));
    CHECK(left.y == doctest::Approx(250));
    CHECK(film.pixels_per_unit(film.seen({0, 0, z}).z) == 50);
  }
  LabelContent content = content_of(800, 600);
  content.camera = camera;
  content.settings.scale_bar = true;
  Image image = grey(800, 600, 1);
  std::vector<float> opaque;
  Labels{content}.draw(image, opaque, {});
  const double em = 8 * dots_per_inch(content.settings, 800) / 72;
  const auto [first, last] = extent(image, static_cast<std::uint32_t>(600 - 0.925 * em), 0);
  CHECK(last + 1 - first == doctest::Approx(100).epsilon(0.02));  // 2 units
}

TEST_CASE("points of the scene are shown where the camera's rays to them start") {
  Camera camera = camera_of(50);
  camera.look_from = {3, 4, 5};
  camera.look_at = {-1, 0.5, 0};
  const CameraFilm film(camera, 640, 480);
  const Point middle = film.shown(film.seen(camera.look_at));
  CHECK(middle.x == doctest::Approx(320));
  CHECK(middle.y == doctest::Approx(240));
  CHECK(film.seen(camera.look_at).z == doctest::Approx(film.distance()));
  const Vec3d back = normalize(camera.look_from - camera.look_at);
  const Vec3d right = normalize(cross(camera.up, back));
  const Vec3d up = cross(back, right);
  const Vec3d corner = camera.look_from + 7.0 * (camera.tan_half_vfov * (640.0 / 480) * right +
                                                 camera.tan_half_vfov * up - back);
  CHECK(film.shown(film.seen(corner)).x == doctest::Approx(640));
  CHECK(film.shown(film.seen(corner)).y == doctest::Approx(0).scale(1));
}

TEST_CASE("the height of text follows from its points and the resolution of print") {
  LabelSettings settings;
  CHECK(dots_per_inch(settings, 1200) == doctest::Approx(254));
  CHECK(dots_per_inch(settings, 100) == 96);
  settings.width_mm = 85;
  CHECK(dots_per_inch(settings, 1004) == doctest::Approx(300).epsilon(0.001));
  settings = {.dpi = 600};
  CHECK(dots_per_inch(settings, 100) == 600);
}

// ---- The cell ----------------------------------------------------------------------------------

TEST_CASE("nearer spheres hide the edges behind a cell, and make all others thinner") {
  const ParticleCell cell{{-1, -1, -1}, {Vec3d{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}};
  Camera camera = camera_of(40);
  camera.look_from = {3, 4, 9};  // no edge hides another
  const CameraFilm film(camera, 300, 300);
  const std::vector<CellLine> lines = cell_lines(cell, film);
  REQUIRE(lines.size() == 12);
  CHECK(std::ranges::count(lines, true, &CellLine::behind) == 3);
  const auto drawn = [&](const DepthMap& map, const std::vector<CellLine>& some) {
    Image image = grey(300, 300, 0.8F);
    std::vector<float> opaque;
    Canvas canvas(image, opaque);
    draw_lines(canvas, some, film, map, 2);
    return image;
  };
  std::vector<CellLine> behind = lines;
  std::erase_if(behind, [](const CellLine& line) { return !line.behind; });
  std::vector<CellLine> front = lines;
  std::erase_if(front, [](const CellLine& line) { return line.behind; });
  const Image all = drawn({}, lines);
  const std::vector<float> sky(300 * 300, std::numeric_limits<float>::infinity());
  CHECK(drawn({sky, {}, 0}, lines).rgb == all.rgb);
  const std::vector<float> wall(300 * 300, 1.0F);
  CHECK(changed(drawn({wall, {}, 0}, behind), 0.8F) == 0);
  // Every part of the front lines is still there, but paler.
  const Image open = drawn({}, front);
  const Image hidden = drawn({wall, {}, 0}, front);
  for (const CellLine& line : front) {
    for (double share = 0.05; share < 1; share += 0.05) {
      const auto x = static_cast<std::size_t>(line.from.x + share * (line.to.x - line.from.x));
      const auto y = static_cast<std::size_t>(line.from.y + share * (line.to.y - line.from.y));
      CHECK(hidden.rgb[3 * (300 * y + x)] < 0.75F);
      CHECK(hidden.rgb[3 * (300 * y + x)] > open.rgb[3 * (300 * y + x)]);
    }
  }
  // Ground and lights of an automatic scene hide nothing.
  const std::vector<std::uint32_t> ground(300 * 300, 1);
  CHECK(drawn({wall, ground, 2}, lines).rgb == all.rgb);
  CHECK(changed(drawn({wall, ground, 1}, behind), 0.8F) == 0);
}

TEST_CASE("lines of a cell are grey, without a halo") {
  const ParticleCell cell{{-1, -1, -1}, {Vec3d{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}};
  const CameraFilm film(camera_of(40), 300, 300);
  for (const auto& [background, line] : {std::pair(0.8F, 0.127F), std::pair(0.02F, 0.402F)}) {
    Image image = grey(300, 300, background);
    std::vector<float> opaque;
    Canvas canvas(image, opaque);
    draw_lines(canvas, cell_lines(cell, film), film, {}, 2);
    const auto [least, most] = std::minmax_element(image.rgb.begin(), image.rgb.end());
    CHECK(*least == doctest::Approx(std::min(background, line)).epsilon(0.01));
    CHECK(*most == doctest::Approx(std::max(background, line)).epsilon(0.01));
  }
}

TEST_CASE("a legend's title replaces the name and the unit of the numbers") {
  Legend legend = velocity;
  set_title(legend, {});
  CHECK(legend == velocity);
  set_title(legend, {.legend_title = "speed (m/s)"});
  CHECK(legend.title == "speed (m/s)");
  CHECK(legend.unit.empty());
  LabelContent content = content_of(600, 400);
  content.settings = {.legend = true, .legend_title = "\u4e2d"};
  content.legends = {velocity};
  CHECK(refusal(content).starts_with("--legend-title: the font DejaVu Sans has no character"));
}

TEST_CASE("a legend of positions has the unit of the settings, as a scale bar has") {
  Legend heights = velocity;
  heights.title = "z";
  const auto unit_in = [](Legend legend, const std::string& unit) {
    set_title(legend, {.unit = unit});
    return legend.unit;
  };
  CHECK(unit_in(heights, "") == heights.unit);
  CHECK(unit_in(heights, "um") == "\u00b5m");
  CHECK(unit_in(heights, " ").empty());
  CHECK(unit_in(velocity, "um") == velocity.unit);
}

TEST_CASE("a cell around the camera is drawn only in front of the camera") {
  const ParticleCell cell{{-20, -20, -20}, {Vec3d{40, 0, 0}, {0, 40, 0}, {0, 0, 40}}};
  const CameraFilm film(camera_of(60), 200, 100);
  const std::vector<CellLine> lines = cell_lines(cell, film);
  CHECK(lines.size() == 8);  // four behind
  for (const CellLine& line : lines) {
    CHECK(line.from_z > 0);
    CHECK(line.to_z > 0);
    for (const double value : {line.from.x, line.from.y, line.to.x, line.to.y}) {
      CHECK(std::isfinite(value));
    }
  }
  Image image = grey(200, 100, 0.1F);
  std::vector<float> opaque;
  Canvas canvas(image, opaque);
  draw_lines(canvas, lines, film, {}, 1);
}

TEST_CASE("the names of a cell's edges are outside its outline") {
  const ParticleCell cell{{-1, -1, -1}, {Vec3d{2, 0, 0}, {0, 2, 0}, {0, 0, 2}}};
  Camera camera = camera_of(40);
  camera.look_from = {8, 5, 6};
  const CameraFilm film(camera, 400, 400);
  const std::vector<EdgeName> names = edge_names(cell, film, 10);
  REQUIRE(names.size() == 3);
  double left = 400;
  double right = 0;
  for (const CellLine& line : cell_lines(cell, film)) {
    left = std::min({left, line.from.x, line.to.x});
    right = std::max({right, line.from.x, line.to.x});
  }
  CHECK((names[1].middle.x < left || names[1].middle.x > right));  // b is upright
  for (const EdgeName& edge : names) {
    double nearest = 1e9;
    for (const CellLine& line : cell_lines(cell, film)) {
      const Point at{(line.from.x + line.to.x) / 2, (line.from.y + line.to.y) / 2};
      nearest = std::min(nearest, std::hypot(at.x - edge.middle.x, at.y - edge.middle.y));
    }
    CHECK(nearest == doctest::Approx(10));
  }
}

TEST_CASE("the names of nearly parallel axes do not overlap") {
  const Font font(20);
  const BlockStyle style{font, 1, 300};
  Camera camera = camera_of(40);
  camera.look_from = {0.2, -10, 9.9};
  camera.up = {0, 0, 1};
  const Block block = axes_block(style, CameraFilm(camera, 300, 300));
  Image image = grey(300, 300, 1);
  std::vector<float> opaque;
  Canvas canvas(image, opaque);
  Pen pen(font, 1, {20, 20, block.width, block.height});
  block.draw(pen, {20, 20});
  pen.draw_on(canvas);
  CHECK(changed(image, 1) > 200);
  for (std::size_t i = 0; i < 300; ++i) {  // nothing is drawn beyond its place
    CHECK(image.rgb[3 * i] == 1);
    CHECK(image.rgb[std::size_t{3} * 300 * i] == 1);
  }
}

// ---- Ink ---------------------------------------------------------------------------------------

TEST_CASE("labels are black on light pictures and white on dark ones, with a halo of the other") {
  LabelContent content = content_of(300, 200);
  content.settings.text = "Label";
  for (const auto& [background, ink] : {std::pair(0.9F, 0.0F), std::pair(0.02F, 1.0F)}) {
    Image image = grey(300, 200, background);
    std::vector<float> opaque;
    Labels{content}.draw(image, opaque, {});
    const auto [least, most] = std::minmax_element(image.rgb.begin(), image.rgb.end());
    CHECK(*(ink == 0 ? least : most) == doctest::Approx(ink).epsilon(0.01));
    CHECK(*(ink == 0 ? most : least) == doctest::Approx(1 - ink).epsilon(0.3).scale(1));
    CHECK(image.rgb.back() == background);  // far from it
  }
}

TEST_CASE("a shape grows by the given radius on all sides") {
  Coverage square(Box{0, 0, 60, 60});
  square.add(Box{20, 20, 10, 10});
  const Coverage grown = square.grown(4);
  // The square, four sides, and four quarters of a disc, of pixels.
  CHECK(grown.area() == doctest::Approx(100 + 160 + std::numbers::pi * 16).epsilon(0.03));
  CHECK(grown.at(25, 25) == 1);
  CHECK(grown.at(25, 16) == 1);
  CHECK(grown.at(25, 15) == 0);
  CHECK(grown.at(16, 16) == 0);  // a corner is round
  CHECK(square.grown(0).area() == doctest::Approx(100));
}

TEST_CASE("on a transparent picture a label has the alpha of what it covers") {
  LabelContent content = content_of(300, 200);
  content.settings.text = "Label";
  Image image = grey(300, 200, 0);
  std::vector<float> alpha(300 * 200, 0);
  Labels{content}.draw(image, alpha, {});
  CHECK(*std::max_element(alpha.begin(), alpha.end()) == doctest::Approx(1));
  CHECK(alpha.back() == 0);
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    CHECK(alpha[i] >= 0);
    CHECK(image.rgb[3 * i] <= alpha[i] + 1e-6F);  // premultiplied: never more than covers
  }
}

TEST_CASE("a colour bar has its scale's colours, the lowest at the bottom") {
  LabelContent content = content_of(600, 400);
  content.settings.legend = true;
  content.legends = {velocity};
  Image image = grey(600, 400, 0.5F);
  std::vector<float> opaque;
  Labels{content}.draw(image, opaque, {});
  double red_y = 0;
  double blue_y = 0;
  double reds = 0;
  double blues = 0;
  for (std::size_t y = 0; y < 400; ++y) {
    for (std::size_t x = 0; x < 600; ++x) {
      const float* const rgb = &image.rgb[3 * (600 * y + x)];
      if (rgb[1] != 0 || rgb[0] + rgb[2] < 0.99F) continue;
      (rgb[0] > 0.9F   ? red_y
       : rgb[2] > 0.9F ? blue_y
                       : reds) += rgb[0] > 0.9F || rgb[2] > 0.9F ? static_cast<double>(y) : 0;
      reds += rgb[0] > 0.9F ? 1 : 0;
      blues += rgb[2] > 0.9F ? 1 : 0;
    }
  }
  REQUIRE(reds > 20);
  REQUIRE(blues > 20);
  CHECK(red_y / reds + 20 < blue_y / blues);
}

}  // namespace parray
