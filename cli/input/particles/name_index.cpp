#include "cli/input/particles/name_index.h"

#include <utility>

#include "common/base/printable.h"

namespace parray::input {

void NameIndex::add(std::string_view name, const FilePlace& place) {
  // Neighbours mostly share chain and residue.
  if (!column_.index.empty() && column_.names[column_.index.back()] == name) {
    column_.index.push_back(column_.index.back());
    return;
  }
  if (name.size() > max_bytes) {
    place.fail("the name '" + printable(name) + "' is longer than " + std::to_string(max_bytes) +
               " bytes: shorten it");
  }
  column_.index.push_back(number_of(name));
}

std::uint32_t NameIndex::number_of(std::string_view name) {
  auto known = numbers_.find(name);
  if (known == numbers_.end()) {
    known = numbers_.emplace(std::string(name), static_cast<std::uint32_t>(numbers_.size())).first;
    column_.names.emplace_back(name);
  }
  return known->second;
}

void NameIndex::drop_unused() {
  const NameColumn before = std::exchange(column_, {});
  numbers_.clear();
  for (const std::uint32_t index : before.index) {
    column_.index.push_back(number_of(before.names[index]));
  }
}

NameColumn NameIndex::finish() { return unnamed() ? NameColumn{} : std::move(column_); }

}  // namespace parray::input
