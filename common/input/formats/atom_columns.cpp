#include "common/input/formats/atom_columns.h"

#include "common/input/particles/elements.h"

namespace parray {

void AtomColumns::add(const Atom& atom) {
  if (atom.alternative_location && !is_new(atom)) return;
  columns_.position(atom.position);
  columns_.element(atom.atomic_number);
  columns_.type(element(atom.atomic_number).symbol);
}

/// Whether no location of the atom is there yet. If one is, the better of the two stays.
bool AtomColumns::is_new(const Atom& atom) {
  const std::string& residue_name =
      residue_names_.try_emplace(atom.residue, atom.residue_name).first->second;
  if (residue_name != atom.residue_name) return false;
  const auto [kept, fresh] =
      kept_.try_emplace(atom.residue + '\0' + atom.name, Kept{columns_.count(), atom.occupancy});
  if (fresh || atom.occupancy <= kept->second.occupancy) return fresh;
  columns_.move(kept->second.index, atom.position);
  kept->second.occupancy = atom.occupancy;
  return false;
}

}  // namespace parray
