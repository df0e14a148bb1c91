#include "common/scene/duplicates.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace parray {
namespace {

bool same_place(const Sphere& a, const Sphere& b) {
  return a.center == b.center && a.radius == b.radius;
}

/// The steps of splitmix64, over the bits of the four numbers.
/// Source: Steele, Lea, Flood, "Fast splittable pseudorandom number generators", OOPSLA 2014.
std::uint64_t hash_of(const Sphere& sphere) {
  std::uint64_t hash = 0;
  for (const double x : {sphere.center.x, sphere.center.y, sphere.center.z, sphere.radius}) {
    hash += 0x9E3779B97F4A7C15 + std::bit_cast<std::uint64_t>(x + 0.0);  // -0 + 0 is 0
    hash = (hash ^ (hash >> 30)) * 0xBF58476D1CE4E5B9;
    hash = (hash ^ (hash >> 27)) * 0x94D049BB133111EB;
    hash ^= hash >> 31;
  }
  return hash;
}

/// Open-addressing table of places in a list of spheres.
class PlaceTable {
 public:
  explicit PlaceTable(const std::vector<Sphere>& spheres)
      : spheres_(spheres), slots_(std::bit_ceil(spheres.size() + spheres.size() / 2 + 1)) {}

  /// The place in the table of the sphere in the same place as `sphere`; puts `place` there if
  /// there is none.
  std::uint32_t find_or_add(const Sphere& sphere, std::uint32_t place) {
    const std::uint64_t hash = hash_of(sphere);
    const auto tag = static_cast<std::uint32_t>(hash >> 32);
    for (std::size_t i = hash & (slots_.size() - 1);; i = (i + 1) & (slots_.size() - 1)) {
      Slot& slot = slots_[i];
      if (slot.place == empty) {
        slot = {tag, place};
        return place;
      }
      if (slot.tag == tag && same_place(spheres_[slot.place], sphere)) {
        return slot.place;
      }
    }
  }

 private:
  static constexpr std::uint32_t empty = std::numeric_limits<std::uint32_t>::max();
  struct Slot {
    std::uint32_t tag = 0;  ///< of the hash: most others are told apart without a look at them
    std::uint32_t place = empty;
  };

  const std::vector<Sphere>& spheres_;
  std::vector<Slot> slots_;
};

/// Keeps the materials that spheres use, in the order in which they first do.
void drop_unused_materials(Scene& scene) {
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> numbers(scene.materials.size(), none);
  std::vector<Material> used;
  for (Sphere& sphere : scene.spheres) {
    std::uint32_t& number = numbers[sphere.material];
    if (number == none) {
      number = static_cast<std::uint32_t>(used.size());
      used.push_back(scene.materials[sphere.material]);
    }
    sphere.material = number;
  }
  scene.materials = std::move(used);
}

}  // namespace

Duplicates remove_duplicates(Scene& scene) {
  Duplicates result;
  std::vector<Sphere>& spheres = scene.spheres;
  PlaceTable table(spheres);
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Sphere sphere = spheres[i];
    const std::uint32_t place = table.find_or_add(sphere, kept);
    if (place == kept) {
      spheres[kept++] = sphere;
    } else if (++result.count == 1) {
      result.first = i;
      result.first_of = place;  // nothing before it has moved
    }
  }
  if (result.count > 0) {
    spheres.resize(kept);
    drop_unused_materials(scene);
  }
  return result;
}

}  // namespace parray
