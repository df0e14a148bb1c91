#pragma once

#include <string>
#include <string_view>
#include <unordered_map>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Builds a NameColumn name by name.
class NameList {
 public:
  void add(std::string_view name);
  NameColumn take() { return std::move(column_); }

 private:
  NameColumn column_;
  std::unordered_map<std::string, std::uint32_t> known_;
};

}  // namespace parray::input
