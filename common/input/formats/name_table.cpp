#include "common/input/formats/name_table.h"

#include <algorithm>
#include <utility>

#include "common/input/particles/element_mass.h"

namespace parray {

void NameTable::add(const NamedAtom& atom) {
  names_.add(atom.name, place_);
  types_.add(atom.type, place_);
  residues_.add(atom.residue_name, place_);
  chains_.add(atom.chain, place_);
  residue_numbers_.push_back(atom.residue_number);
  charges_.push_back(atom.charge);
  masses_.push_back(atom.mass);
}

Particles NameTable::finish(const ParticleRequest& request, std::vector<std::uint8_t> elements) {
  if (masses_.empty()) place_.fail("no atoms: is this the right file?");
  Particles particles;
  particles.positions.resize(masses_.size());
  if (elements.empty()) {
    elements = elements_of_masses(masses_);
    const auto known = static_cast<std::uint64_t>(
        std::ranges::count_if(elements, [](std::uint8_t element) { return element != 0; }));
    if (known > 0) particles.facts.notes.push_back(masses_note(known));
  }
  const bool any = std::ranges::any_of(elements, [](std::uint8_t element) { return element != 0; });
  if (any) particles.elements = std::move(elements);
  particles.atom_names = names_.finish();
  particles.types = types_.finish();
  particles.residue_names = residues_.finish();
  particles.chains = chains_.finish();
  particles.residue_numbers = std::move(residue_numbers_);
  if (request.wants("charge")) particles.numbers.push_back({"charge", std::move(charges_)});
  if (request.wants("mass")) particles.numbers.push_back({"mass", std::move(masses_)});
  return particles;
}

}  // namespace parray
