#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <unordered_map>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particles.h"

namespace parray::input {

/// Builds a NameColumn, which keeps every name once.
class NameIndex {
 public:
  static constexpr std::size_t max_bytes = 256;

  /// Appends a particle of that name. Fails at `place` for a name of more than max_bytes.
  void add(std::string_view name, const FilePlace& place);
  /// The number of a name, which is new or not.
  std::uint32_t number_of(std::string_view name);
  /// Calls a particle that is there otherwise.
  void rename(std::size_t particle, std::string_view name) {
    column_.index[particle] = number_of(name);
  }

  /// Forgets names that no particle has any more.
  void drop_unused();

  [[nodiscard]] const NameColumn& column() const { return column_; }
  /// All names are empty, as in a file that has none.
  [[nodiscard]] bool unnamed() const {
    return column_.names.empty() || (column_.names.size() == 1 && column_.names[0].empty());
  }
  /// The column; none where it is unnamed().
  NameColumn finish();

 private:
  struct Hash : std::hash<std::string_view> {
    using is_transparent = void;  // NOLINT(readability-identifier-naming): the library's name
  };
  NameColumn column_;
  std::unordered_map<std::string, std::uint32_t, Hash, std::equal_to<>> numbers_;
};

}  // namespace parray::input
