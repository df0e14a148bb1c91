#include "common/scene/origin.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "common/base/bands.h"
#include "common/math/largest_component.h"

namespace parray::scene {
namespace {

/// Returns the centre of a sphere, or of a capsule, which is numbered after the spheres.
Vec3d center_of(const Scene& scene, std::size_t shape) {
  if (shape < scene.spheres.size()) return scene.spheres[shape].center;
  const Capsule& capsule = scene.capsules[shape - scene.spheres.size()];
  return 0.5 * (capsule.from + capsule.to);
}

/// A range that probably contains a median.
struct Bracket {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
};

/// Returns a bracket of the median of value_at(i), 0 <= i < count, from a sample. It contains the
/// median except by chance (one in ten thousand) or if the values have some regularity.
Bracket bracket_of(std::size_t count, const auto& value_at) {
  constexpr std::size_t size = 4096;
  constexpr std::size_t reach = 128;  // four standard deviations of the sample's median
  const std::size_t step = count / size;
  if (step < 2) return {};
  std::vector<double> sample;
  for (std::size_t i = 0; i < size; ++i) sample.push_back(value_at(i * step));
  std::ranges::sort(sample);
  return {sample[size / 2 - reach], sample[size / 2 + reach]};
}

/// Returns the median of value_at(i), 0 <= i < count, if the bracket contains it.
std::optional<double> median_within(const Bracket& bracket, std::size_t count, int threads,
                                    const auto& value_at) {
  /// The number of values below the bracket, and the values in it.
  struct Part {
    std::size_t below = 0;
    std::vector<double> inside;
  };
  const Bands bands(count, threads);
  std::vector<Part> parts(bands.count());
  bands.run([&](std::size_t band, std::size_t begin, std::size_t end) {
    Part part;
    for (std::size_t i = begin; i < end; ++i) {
      const double value = value_at(i);
      part.below += value < bracket.least ? 1U : 0U;
      if (value >= bracket.least && value <= bracket.most) part.inside.push_back(value);
    }
    parts[band] = std::move(part);
  });
  const std::size_t rank = count / 2;
  std::size_t below = 0;
  std::vector<double> inside;
  for (const Part& part : parts) {
    below += part.below;
    inside.insert(inside.end(), part.inside.begin(), part.inside.end());
  }
  if (rank < below || rank - below >= inside.size()) return {};
  const auto middle = inside.begin() + static_cast<std::ptrdiff_t>(rank - below);
  std::nth_element(inside.begin(), middle, inside.end());
  return *middle;
}

/// Returns the median of a value of each shape, `value(centre)`. It uses all shapes, because a
/// choice of some would depend on their order. The result is exact whatever the bracket is.
double median_of(const Scene& scene, int threads, const auto& value) {
  const std::size_t count = scene.spheres.size() + scene.capsules.size();
  const auto value_at = [&](std::size_t i) { return value(center_of(scene, i)); };
  const auto found = median_within(bracket_of(count, value_at), count, threads, value_at);
  return found ? *found : *median_within({}, count, threads, value_at);
}

/// Returns the distance from `origin` within which the camera and half of the shapes lie.
double reach(const Scene& scene, const Vec3d& origin, int threads) {
  const auto distance = [&](const Vec3d& p) { return largest_component(p - origin); };
  return std::max(median_of(scene, threads, distance),
                  largest_component(scene.camera.look_from - origin));
}

}  // namespace

Vec3d scene_origin(const Scene& scene, int threads) {
  if (scene.spheres.empty() && scene.capsules.empty()) return {};
  const Vec3d middle{median_of(scene, threads, [](const Vec3d& p) { return p.x; }),
                     median_of(scene, threads, [](const Vec3d& p) { return p.y; }),
                     median_of(scene, threads, [](const Vec3d& p) { return p.z; })};
  // By the triangle inequality no scene can then come four times nearer; most scenes end here.
  if (3 * largest_component(scene.camera.look_from - middle) > largest_component(middle)) return {};
  return 4 * reach(scene, middle, threads) <= reach(scene, {}, threads) ? middle : Vec3d{};
}

}  // namespace parray::scene
