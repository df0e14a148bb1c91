#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "common/scene/scene.h"

namespace parray::input {

struct NamedMaterial {
  std::string_view name;  ///< refers to the MaterialNames object
  Material material;
};

/// The named materials of a scene. Uses and definitions may come in any order. The number of a name
/// is its place in the order of first mention.
class MaterialNames {
 public:
  struct Entry {
    std::optional<Material> value;  ///< nothing: not defined yet
    // The first shape that uses the name, if first_line > 0.
    std::string_view first_section;  ///< "spheres" or "capsules"
    std::size_t first_shape = 0;     ///< its number in the section
    std::uint64_t first_line = 0;    ///< line of that use; 0: not used yet
  };

  /// Records that shape number `shape` of `section`, a literal, uses `name` on `line`. Returns the
  /// number of the name.
  std::uint32_t use(const std::string& name, std::string_view section, std::size_t shape,
                    std::uint64_t line);

  /// Returns the number of a name that a shape has already used. Returns nothing for other names.
  std::optional<std::uint32_t> used(std::string_view name) const;

  /// Defines a material. Returns false if the name is already defined.
  bool define(const std::string& name, const Material& material);

  /// Returns the entry of the name with this number, below size().
  const Entry& operator[](std::uint32_t number) const { return entries_[number]; }
  std::size_t size() const { return entries_.size(); }

  /// Returns the material; nullptr if the name is not defined. Valid until the next use() or
  /// define().
  const Material* find(const std::string& name) const;
  /// Returns the defined materials in the order of their numbers.
  std::vector<NamedMaterial> defined() const;

  /// Returns the remedy for an undefined name, as the end of a message. `words` are further valid
  /// texts. `otherwise` is the remedy if no valid text is similar.
  std::string remedy_for_undefined(std::string_view name,
                                   std::span<const std::string_view> words = {},
                                   std::string_view otherwise = "define it in /materials") const;
  /// Returns the name with a number. Returns "" if there is none. Takes linear time.
  std::string_view name_of(std::uint32_t number) const;

 private:
  std::uint32_t number_of(const std::string& name);

  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;  // NOLINT(readability-identifier-naming): the library's name
  };
  std::unordered_map<std::string, std::uint32_t, Hash, std::equal_to<>> numbers_;
  std::vector<Entry> entries_;
};

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
