#include "cli/output/postprocess/outline_and_depth_cue.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "cli/input/color/number_bounds.h"
#include "cli/output/labels/camera_film.h"
#include "cli/output/labels/canvas.h"
#include "common/base/bands.h"

namespace parray::postprocess {
namespace {

/// Returns whether the test is true for a pixel and its left, right, upper and lower neighbours.
bool all_around(std::size_t pixel, std::size_t width, std::size_t count, const auto& test) {
  return test(pixel) && (pixel % width == 0 || test(pixel - 1)) &&
         (pixel % width == width - 1 || test(pixel + 1)) &&
         (pixel < width || test(pixel - width)) && (pixel + width >= count || test(pixel + width));
}

constexpr std::uint32_t sky = UINT32_MAX;
constexpr double infinity = std::numeric_limits<double>::infinity();
/// In radii of a silhouette: a smaller step in depth draws nothing, a step of the second size or
/// more draws the full line.
constexpr double least_step = 0.02;
constexpr double full_step = 0.3;
/// Distance from a silhouette, in pixels, at which the neighbourhood is examined.
constexpr double beside = 0.75;

/// A sphere (`axis` is 0) or a capsule, in camera coordinates.
struct Shape {
  Vec3d from;
  Vec3d axis;  ///< to the other end
  double radius;
};

/// A line of sight in camera coordinates: through `origin`, along a direction with z = 1.
struct Sight {
  Vec3d origin;
  Vec3d direction;

  /// Returns the point of the segment that is nearest to the line. There, a capsule looks like a
  /// sphere.
  [[nodiscard]] Vec3d center_of(const Shape& shape) const {
    const auto across = [this](const Vec3d& v) {
      return v - (dot(v, direction) / dot(direction, direction)) * direction;
    };
    const Vec3d along = across(shape.axis);
    const double square = dot(along, along);
    if (!(square > 0)) return shape.from;
    const double share = dot(across(origin - shape.from), along) / square;
    return shape.from + std::clamp(share, 0.0, 1.0) * shape.axis;
  }
  /// Returns the depth at which the line is nearest to the shape's centre.
  [[nodiscard]] double nearest_depth(const Shape& shape) const {
    const Vec3d to_center = center_of(shape) - origin;
    return origin.z + dot(to_center, direction) / dot(direction, direction);
  }
  /// Returns its distance from the shape's centre.
  [[nodiscard]] double distance(const Shape& shape) const {
    return length(cross(center_of(shape) - origin, direction)) / length(direction);
  }
  /// Returns the depth at which the line enters the shape, about that for a capsule.
  [[nodiscard]] std::optional<double> entry_depth(const Shape& shape) const {
    const double off = distance(shape);
    if (off >= shape.radius) return {};
    const double half_chord = square_root(shape.radius * shape.radius - off * off);
    return nearest_depth(shape) - half_chord / length(direction);
  }
};

/// The silhouette of a sphere near a point of the picture.
struct Silhouette {
  double distance;  ///< distance of the point, in pixels; negative inside
  Point outwards;   ///< unit vector in the picture
  Point nearest;    ///< point of the silhouette
};

class Outliner {
 public:
  Outliner(const Scene& scene, std::uint32_t width, std::uint32_t height, const SeenSpheres& seen,
           double line_width, const DepthFade& fade)
      : scene_(scene),
        film_(scene.camera, width, height),
        width_(static_cast<int>(width)),
        height_(static_cast<int>(height)),
        scale_(film_.pixels_per_unit(1)),
        seen_(seen),
        line_width_(line_width),
        fade_(fade) {}

  /// Returns the covered share of the pixel. Considers spheres seen up to `reach` pixels away.
  [[nodiscard]] float share(int x, int y, int reach, std::vector<std::uint32_t>& near) const {
    collect(x, y, reach, near);
    double share = 0;
    for (const std::uint32_t number : near) {
      share = std::max(share, share_of(number, {x + 0.5, y + 0.5}));
    }
    return static_cast<float>(share);
  }

  /// Returns whether the right or lower neighbour of the pixel shows another sphere.
  [[nodiscard]] bool at_edge(int x, int y) const {
    const std::uint32_t here = at(x, y);
    return (x + 1 < width_ && at(x + 1, y) != here) || (y + 1 < height_ && at(x, y + 1) != here);
  }

 private:
  [[nodiscard]] std::uint32_t at(int x, int y) const {
    return seen_.sphere[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                        static_cast<std::size_t>(x)];
  }
  [[nodiscard]] bool is_background(std::uint32_t number) const {
    return number == sky || number < seen_.scenery;
  }

  [[nodiscard]] Shape shape_of(std::uint32_t number) const {
    if (number < scene_.spheres.size()) {
      const Sphere& sphere = scene_.spheres[number];
      return {film_.seen(sphere.center), {}, sphere.radius};
    }
    const Capsule& capsule = scene_.capsules[number - scene_.spheres.size()];
    const Vec3d from = film_.seen(capsule.from);
    return {from, film_.seen(capsule.to) - from, capsule.radius};
  }

  [[nodiscard]] Sight sight(const Point& at) const {
    const Vec3d film{(at.x - 0.5 * width_) / scale_, (0.5 * height_ - at.y) / scale_, 0};
    if (film_.perspective()) return {{0, 0, 0}, film + Vec3d{0, 0, 1}};
    return {film, {0, 0, 1}};
  }

  /// Calls `use` with the sphere in each pixel of the picture up to `reach` pixels away.
  void around(int x, int y, int reach, const auto& use) const {
    for (int v = std::max(y - reach, 0); v <= std::min(y + reach, height_ - 1); ++v) {
      for (int u = std::max(x - reach, 0); u <= std::min(x + reach, width_ - 1); ++u) use(at(u, v));
    }
  }

  /// Collects the spheres that are seen up to `reach` pixels away, without repetition.
  void collect(int x, int y, int reach, std::vector<std::uint32_t>& near) const {
    near.clear();
    around(x, y, reach, [&](std::uint32_t number) {
      if (is_background(number)) return;
      if (near.empty() ||
          (near.back() != number && std::ranges::find(near, number) == near.end())) {
        near.push_back(number);
      }
    });
  }

  /// Computes the silhouette from the first terms of Taylor's series. It is precise enough some
  /// pixels away.
  [[nodiscard]] std::optional<Silhouette> silhouette(const Shape& shape, const Point& from) const {
    constexpr double step = 0.25;
    const auto off = [&](double dx, double dy) {
      return sight({from.x + dx, from.y + dy}).distance(shape) - shape.radius;
    };
    const Point slope{(off(step, 0) - off(-step, 0)) / (2 * step),
                      (off(0, step) - off(0, -step)) / (2 * step)};
    const double steepness = std::hypot(slope.x, slope.y);
    if (!(steepness > 0)) return {};
    const double distance = off(0, 0) / steepness;
    const Point outwards{slope.x / steepness, slope.y / steepness};
    return Silhouette{
        distance, outwards, {from.x - distance * outwards.x, from.y - distance * outwards.y}};
  }

  /// Calls `use` with the sphere in the pixel of a point and in its neighbours inside the picture.
  void around(const Point& point, const auto& use) const {
    around(static_cast<int>(std::floor(point.x)), static_cast<int>(std::floor(point.y)), 1, use);
  }

  /// Returns the distance in depth from the silhouette, at `depth`, to what is visible beside it.
  /// Returns 0 if no part of the sphere is visible, or if something is in front.
  [[nodiscard]] double step_at(std::uint32_t number, const Silhouette& line, double depth) const {
    bool visible = false;
    around({line.nearest.x - beside * line.outwards.x, line.nearest.y - beside * line.outwards.y},
           [&](std::uint32_t other) { visible |= other == number; });
    if (!visible) return 0;
    const Point outside{line.nearest.x + beside * line.outwards.x,
                        line.nearest.y + beside * line.outwards.y};
    const Sight outer = sight(outside);
    double front = infinity;
    bool other_seen = false;
    around(outside, [&](std::uint32_t other) {
      if (other == number) return;
      other_seen = true;
      if (is_background(other)) return;
      const std::optional<double> entry = outer.entry_depth(shape_of(other));
      front = std::min(front, entry.value_or(infinity));
    });
    return other_seen ? front - depth : 0;
  }

  [[nodiscard]] double share_of(std::uint32_t number, const Point& pixel) const {
    const Shape shape = shape_of(number);
    const std::optional<Silhouette> line = silhouette(shape, pixel);
    if (!line) return 0;
    const double share = line_share(std::abs(line->distance), line_width_);
    if (share <= 0) return 0;
    const double depth = sight(line->nearest).nearest_depth(shape);
    if (!(depth > 0)) return 0;
    const double pixels =
        shape.radius * film_.pixels_per_unit(sight(line->nearest).center_of(shape).z);
    const double size = std::clamp(2 * pixels / line_width_ - 1, 0.0, 1.0);
    const double step = step_at(number, *line, depth) / shape.radius;
    const double strength = std::clamp((step - least_step) / (full_step - least_step), 0.0, 1.0);
    return share * size * strength * (1 - fade_(depth));
  }

  const Scene& scene_;
  CameraFilm film_;
  int width_;
  int height_;
  double scale_;
  const SeenSpheres& seen_;
  double line_width_;
  const DepthFade& fade_;
};

/// Returns marks for all pixels up to `reach` away, along x and y, from a marked pixel.
std::vector<char> grown(const std::vector<char>& marks, int width, int height, int reach) {
  std::vector<char> wide(marks.size());
  std::vector<char> out(marks.size());
  const auto spread = [reach](const std::vector<char>& from, std::vector<char>& to,
                              std::size_t start, std::size_t stride, int count) {
    for (const bool forward : {true, false}) {
      int left = 0;  // number of places still within reach of the last mark
      for (int i = 0; i < count; ++i) {
        const auto place = static_cast<std::size_t>(forward ? i : count - 1 - i);
        left = from[start + place * stride] != 0 ? reach + 1 : left - 1;
        if (left > 0) to[start + place * stride] = 1;
      }
    }
  };
  const auto row = static_cast<std::size_t>(width);
  for (int y = 0; y < height; ++y) spread(marks, wide, static_cast<std::size_t>(y) * row, 1, width);
  for (int x = 0; x < width; ++x) spread(wide, out, static_cast<std::size_t>(x), row, height);
  return out;
}

}  // namespace

DepthFade::DepthFade(const SeenSpheres& seen, std::uint32_t width, double strength)
    : strength_(strength) {
  const auto in_front = [&](std::size_t pixel) { return !seen.background(pixel); };
  const std::size_t count = seen.sphere.size();
  NumberBounds inner;
  NumberBounds all;
  for (std::size_t i = 0; i < count; ++i) {
    if (!in_front(i) || !std::isfinite(seen.depth[i]) || seen.depth[i] > seen.farthest) continue;
    all.add(seen.depth[i]);
    if (all_around(i, width, count, in_front)) inner.add(seen.depth[i]);
  }
  const NumberBounds& range = inner.empty() ? all : inner;
  if (range.empty()) return;
  nearest_ = range.low;
  range_ = range.high - range.low;
}

double DepthFade::operator()(double depth) const {
  return range_ > 0 ? strength_ * std::clamp((depth - nearest_) / range_, 0.0, 1.0) : 0;
}

Vec3d background_color(const Image& image, const SeenSpheres& seen, const Scene& scene) {
  const auto background = [&](std::size_t pixel) { return seen.background(pixel); };
  const std::size_t count = seen.sphere.size();
  std::array<double, 3> sum{};
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (!all_around(i, image.width, count, background)) continue;
    ++pixels;
    for (std::size_t c = 0; c < 3; ++c) sum[c] += std::min(image.rgb[3 * i + c], 1.0F);
  }
  const Camera& camera = scene.camera;
  const double up = normalize(camera.look_at - camera.look_from).y;
  const Vec3d& horizon = scene.sky.horizon;
  const Vec3d ahead = horizon + ((up + 1) / 2) * (scene.sky.zenith - horizon);
  if (pixels == 0) return {std::min(ahead.x, 1.0), std::min(ahead.y, 1.0), std::min(ahead.z, 1.0)};
  const double share = 1 / static_cast<double>(pixels);
  return share * Vec3d{sum[0], sum[1], sum[2]};
}

void fade(Image& image, std::vector<float>& alpha, const SeenSpheres& seen, const DepthFade& fade,
          const Vec3d& background) {
  const std::array<double, 3> far{background.x, background.y, background.z};
  for (std::size_t i = 0; i < seen.sphere.size(); ++i) {
    const bool staged = seen.sphere[i] < seen.scenery;
    if (staged || !std::isfinite(seen.depth[i])) continue;
    const double lost = fade(seen.depth[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      float& value = image.rgb[3 * i + c];
      value = static_cast<float>((1 - lost) * value + (alpha.empty() ? lost * far[c] : 0));
    }
    if (!alpha.empty()) alpha[i] = static_cast<float>((1 - lost) * alpha[i]);
  }
}

std::vector<float> outline_of(const Scene& scene, std::uint32_t width, std::uint32_t height,
                              const SeenSpheres& seen, double line_width, const DepthFade& fade,
                              int threads) {
  const Outliner outliner(scene, width, height, seen, line_width, fade);
  const int w = static_cast<int>(width);
  const int h = static_cast<int>(height);
  const int reach = static_cast<int>(std::ceil(line_width / 2)) + 1;
  std::vector<char> edges(seen.sphere.size());
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      edges[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] =
          outliner.at_edge(x, y) ? 1 : 0;
    }
  }
  const std::vector<char> candidates = grown(edges, w, h, reach + 1);
  std::vector<float> shares(seen.sphere.size());
  const Bands bands(shares.size(), threads);
  bands.run([&](std::size_t, std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> near;
    for (std::size_t i = begin; i < end; ++i) {
      if (candidates[i] == 0) continue;
      shares[i] =
          outliner.share(static_cast<int>(i % width), static_cast<int>(i / width), reach, near);
    }
  });
  return shares;
}

void draw_ink(Image& image, std::vector<float>& alpha, const std::vector<float>& shares,
              const Vec3d& ink) {
  const double color[] = {ink.x, ink.y, ink.z};
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double share = shares[i];
    if (share == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      float& value = image.rgb[3 * i + c];
      value = static_cast<float>(share * color[c] + (1 - share) * value);
    }
    if (!alpha.empty()) alpha[i] = static_cast<float>(share + (1 - share) * alpha[i]);
  }
}

}  // namespace parray::postprocess
