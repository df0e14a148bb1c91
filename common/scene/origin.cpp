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

/// Computes medians of a value of each shape, `Value(centre)`. It uses all shapes, because a
/// choice of some would depend on their order.
template <typename Value>
class Median {
 public:
  Median(const Scene& scene, const Value& value, int threads)
      : scene_(scene),
        count_(scene.spheres.size() + scene.capsules.size()),
        value_(value),
        bands_(count_, threads) {}

  /// A sample gives a bracket for the median. Then only the values in the bracket are examined. The
  /// result is exact for every sample.
  double find() const {
    const Bracket bracket = sampled();
    if (const std::optional<double> found = within(bracket)) return *found;
    return *within({});
  }

 private:
  struct Bracket {
    double least = -std::numeric_limits<double>::infinity();
    double most = std::numeric_limits<double>::infinity();
  };
  /// The number of values below a bracket, and the values in it.
  struct Part {
    std::size_t below = 0;
    std::vector<double> inside;
  };

  /// Returns a bracket that contains the median, except by chance (one in ten thousand) or if the
  /// values have some regularity.
  [[nodiscard]] Bracket sampled() const {
    constexpr std::size_t size = 4096;
    constexpr std::size_t reach = 128;  // four standard deviations of the sample's median
    const std::size_t step = count_ / size;
    if (step < 2) return {};
    std::vector<double> sample;
    for (std::size_t i = 0; i < size; ++i) sample.push_back(value_(center_of(scene_, i * step)));
    std::ranges::sort(sample);
    return {sample[size / 2 - reach], sample[size / 2 + reach]};
  }

  /// Returns the median if the bracket contains it.
  [[nodiscard]] std::optional<double> within(const Bracket& bracket) const {
    std::vector<Part> parts(bands_.count());
    bands_.run([&](std::size_t band, std::size_t begin, std::size_t end) {
      Part part;
      for (std::size_t i = begin; i < end; ++i) {
        const double value = value_(center_of(scene_, i));
        part.below += value < bracket.least ? 1U : 0U;
        if (value >= bracket.least && value <= bracket.most) part.inside.push_back(value);
      }
      parts[band] = std::move(part);
    });
    const std::size_t rank = count_ / 2;
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

  const Scene& scene_;
  std::size_t count_;
  const Value& value_;
  Bands bands_;
};

double median_of(const Scene& scene, int threads, const auto& value) {
  return Median(scene, value, threads).find();
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
