#include "common/scene/material_names.h"

#include <algorithm>

#include "common/base/printable.h"
#include "common/base/suggest.h"

namespace parray {

std::uint32_t MaterialNames::number_of(const std::string& name) {
  const auto [place, is_new] =
      numbers_.try_emplace(name, static_cast<std::uint32_t>(entries_.size()));
  if (is_new) entries_.emplace_back();
  return place->second;
}

std::uint32_t MaterialNames::use(const std::string& name, std::size_t sphere, std::uint64_t line) {
  const std::uint32_t number = number_of(name);
  Entry& entry = entries_[number];
  if (entry.first_line == 0) {
    entry.first_sphere = sphere;
    entry.first_line = line;
  }
  return number;
}

bool MaterialNames::define(const std::string& name, const Material& material) {
  Entry& entry = entries_[number_of(name)];
  if (entry.value) return false;
  entry.value = material;
  return true;
}

std::string_view MaterialNames::name_of(std::uint32_t number) const {
  for (const auto& [name, known] : numbers_) {
    if (known == number) return name;
  }
  return {};
}

std::string MaterialNames::remedy_for_undefined(std::uint32_t number) const {
  // In alphabetical order, for a message that does not hang on the hash.
  std::vector<std::string_view> defined;
  for (const auto& [name, known] : numbers_) {
    if (entries_[known].value) defined.push_back(name);
  }
  std::sort(defined.begin(), defined.end());
  NearestWord nearest(name_of(number));
  for (const std::string_view name : defined) nearest.offer(name);
  if (nearest.best().empty()) return "define it in /materials";
  return "did you mean '" + printable(nearest.best()) + "'?";
}

}  // namespace parray
