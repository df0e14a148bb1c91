#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/scene/scene.h"

namespace parray {

/// Distinct materials by value, numbered in the order in which they come.
class MaterialTable {
 public:
  /// The number of `material`, new or known. Nothing when it is new and the table holds
  /// limits::max_materials already.
  std::optional<std::uint32_t> intern(const Material& material);

  /// Empties the table.
  std::vector<Material> take();

 private:
  struct Hash {
    std::size_t operator()(const Material& material) const;
  };

  std::vector<Material> materials_;
  std::unordered_map<Material, std::uint32_t, Hash> numbers_;
};

}  // namespace parray
