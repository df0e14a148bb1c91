#include "cli/input/scene_file/material_names.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "common/base/printable.h"
#include "common/base/suggest.h"
#include "common/scene/limits.h"

namespace parray::input {

std::uint32_t MaterialNames::number_of(const std::string& name) {
  const auto [place, is_new] =
      numbers_.try_emplace(name, static_cast<std::uint32_t>(entries_.size()));
  if (is_new) entries_.emplace_back();
  return place->second;
}

std::uint32_t MaterialNames::use(const std::string& name, std::string_view section,
                                 std::size_t shape, std::uint64_t line) {
  const std::uint32_t number = number_of(name);
  Entry& entry = entries_[number];
  if (entry.first_line == 0) {
    entry.first_section = section;
    entry.first_shape = shape;
    entry.first_line = line;
  }
  return number;
}

std::optional<std::uint32_t> MaterialNames::used(std::string_view name) const {
  const auto found = numbers_.find(name);
  if (found == numbers_.end() || entries_[found->second].first_line == 0) return {};
  return found->second;
}

bool MaterialNames::define(const std::string& name, const Material& material) {
  Entry& entry = entries_[number_of(name)];
  if (entry.value) return false;
  entry.value = material;
  return true;
}

const Material* MaterialNames::find(const std::string& name) const {
  const auto found = numbers_.find(name);
  if (found == numbers_.end() || !entries_[found->second].value) return nullptr;
  return &*entries_[found->second].value;
}

std::vector<NamedMaterial> MaterialNames::defined() const {
  std::vector<std::string_view> names(entries_.size());
  for (const auto& [name, number] : numbers_) names[number] = name;
  std::vector<NamedMaterial> out;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].value) out.push_back({names[i], *entries_[i].value});
  }
  return out;
}

std::string_view MaterialNames::name_of(std::uint32_t number) const {
  for (const auto& [name, known] : numbers_) {
    if (known == number) return name;
  }
  return {};
}

std::string MaterialNames::remedy_for_undefined(std::string_view name,
                                                std::span<const std::string_view> words,
                                                std::string_view otherwise) const {
  // Sorts the names, so that the message does not depend on the order of the file.
  std::vector<std::string_view> known(words.begin(), words.end());
  for (const NamedMaterial& material : defined()) known.push_back(material.name);
  std::ranges::sort(known);
  NearestWord nearest(name);
  for (const std::string_view word : known) nearest.offer(word);
  if (nearest.best().empty()) return std::string(otherwise);
  return "did you mean '" + printable(nearest.best()) + "'?";
}

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
