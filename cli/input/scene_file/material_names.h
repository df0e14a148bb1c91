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
  std::string_view name;  ///< refers to the MaterialNames
  Material material;
};

/// The named materials of a scene that is being read. Uses and definitions come in any order; a
/// name's number is its place in the order of first mention.
class MaterialNames {
 public:
  struct Entry {
    std::optional<Material> value;  ///< none: not defined so far
    std::size_t first_sphere = 0;   ///< the first use, where there is one
    std::uint64_t first_line = 0;   ///< 0: not used so far
  };

  /// The number of `name`, which sphere `sphere` uses on `line`.
  std::uint32_t use(const std::string& name, std::size_t sphere, std::uint64_t line);

  /// The number of a name that a sphere has used already.
  std::optional<std::uint32_t> used(std::string_view name) const;

  /// False when the name is defined already.
  bool define(const std::string& name, const Material& material);

  const Entry& operator[](std::uint32_t number) const { return entries_[number]; }
  std::size_t size() const { return entries_.size(); }

  /// Null when the name is not defined.
  const Material* find(const std::string& name) const;
  /// The defined materials, in the order of their numbers.
  std::vector<NamedMaterial> defined() const;

  /// What to do about the undefined name, as the end of a message. `words` would have done, too.
  std::string remedy_for_undefined(std::string_view name,
                                   std::span<const std::string_view> words = {}) const;
  std::string_view name_of(std::uint32_t number) const;

 private:
  std::uint32_t number_of(const std::string& name);

  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;  // NOLINT(readability-identifier-naming): the library's name
  };
  std::unordered_map<std::string, std::uint32_t, Hash, std::equal_to<>> numbers_;
  std::vector<Entry> entries_;
};

}  // namespace parray::input
