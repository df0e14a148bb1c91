#include "cli/input/select/column_names.h"

#include <vector>

#include "cli/input/select/number_source.h"
#include "common/base/suggest.h"

namespace parray::input {

const NameColumn& name_column(std::string_view word, const Particles& particles) {
  if (word == "type") return particles.types;
  if (word == "name") return particles.atom_names;
  return word == "chain" ? particles.chains : particles.residue_names;
}

std::string plural_of(std::string_view word) {
  if (word == "type") return "types";
  if (word == "name") return "atom names";
  return word == "chain" ? "chains" : "residue names";
}

std::string columns_of(const Particles& particles) {
  std::vector<std::string> columns;
  if (!particles.elements.empty()) columns.emplace_back("elements");
  for (const std::string_view word : {"type", "name", "resname", "chain"}) {
    if (!name_column(word, particles).empty()) columns.push_back(plural_of(word));
  }
  for (std::string& name : number_names(particles)) columns.push_back(std::move(name));
  const std::vector<std::string_view> names(columns.begin(), columns.end());
  return list_names(names);
}

}  // namespace parray::input
