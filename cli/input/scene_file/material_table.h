#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/scene/scene.h"

namespace parray::input {

/// A hash of materials that is equal for equal materials and the same on every machine.
struct MaterialHash {
  std::size_t operator()(const Material& material) const;
};

/// Distinct materials, numbered in the order of their first use.
class MaterialTable {
 public:
  /// Returns the number of `material`. Adds new materials. Returns nothing for a new material if
  /// the table already has limits::max_materials.
  std::optional<std::uint32_t> intern(const Material& material);

  /// Returns the materials and empties the table.
  std::vector<Material> take();

 private:
  std::vector<Material> materials_;
  std::unordered_map<Material, std::uint32_t, MaterialHash> numbers_;
};

}  // namespace parray::input
