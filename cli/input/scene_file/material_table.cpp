#include "cli/input/scene_file/material_table.h"

#include <bit>
#include <utility>

#include "common/scene/limits.h"

namespace parray::input {

std::size_t MaterialHash::operator()(const Material& material) const {
  std::uint64_t hash = static_cast<std::uint64_t>(material.type);
  for (const double x :
       {material.albedo.x, material.albedo.y, material.albedo.z, material.fuzz, material.ior}) {
    // Adding zero gives -0 and +0, which are equal, the same hash. The multiplier comes from the
    // golden ratio (Knuth, TAOCP 3, 6.4). The shift moves its well-mixed high bits down.
    hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9E3779B97F4A7C15U;
    hash ^= hash >> 32;
  }
  return static_cast<std::size_t>(hash);
}

std::optional<std::uint32_t> MaterialTable::intern(const Material& material) {
  const auto found = numbers_.find(material);
  if (found != numbers_.end()) return found->second;
  if (materials_.size() == limits::max_materials) return {};
  const auto number = static_cast<std::uint32_t>(materials_.size());
  numbers_.emplace(material, number);
  materials_.push_back(material);
  return number;
}

std::vector<Material> MaterialTable::take() {
  numbers_.clear();
  return std::exchange(materials_, {});
}

}  // namespace parray::input
