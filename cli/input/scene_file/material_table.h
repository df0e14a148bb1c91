#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "common/scene/scene.h"

namespace parray::input {

/// Equal for equal materials; the same on every machine.
struct MaterialHash {
  std::size_t operator()(const Material& material) const;
};

/// Distinct materials by value, numbered in the order in which they come.
class MaterialTable {
 public:
  /// The number of `material`, new or known. Nothing when it is new and the table holds
  /// limits::max_materials already.
  std::optional<std::uint32_t> intern(const Material& material);

  /// Empties the table.
  std::vector<Material> take();

 private:
  std::vector<Material> materials_;
  std::unordered_map<Material, std::uint32_t, MaterialHash> numbers_;
};

}  // namespace parray::input
