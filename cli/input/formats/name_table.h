#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/particles/guess_element.h"
#include "cli/input/particles/residues.h"

namespace parray::input {

/// Collects the atoms of a topology file.
class NameTable {
 public:
  /// `place` is the position of the reader and must outlive this object.
  explicit NameTable(const FilePlace& place) : place_(place) {}

  /// Adds an atom by its names, numbers and type. `charge`: elementary charges; NaN: not known.
  /// `mass`: atomic mass units; NaN: not known.
  void add(const Atom& atom, double charge, double mass) {
    names_.add(atom.name, place_);
    types_.add(atom.type, place_);
    residues_.add(atom.residue_name, place_);
    chains_.add(atom.chain, place_);
    residue_numbers_.push_back(atom.residue_number);
    insertions_.set(masses_.size(), atom.insertion);
    charges_.push_back(charge);
    masses_.push_back(mass);
  }

  /// Returns the atoms with all positions 0. `elements`: one atomic number per atom. If it is
  /// empty, the elements come from the masses. An atom whose mass belongs to no element gets its
  /// element from the names, unless its mass is below 1. Notes count these guesses. Adds the
  /// columns charge and mass if the request wants them. Throws InputError at `place` if there are
  /// no atoms.
  Particles finish(const ParticleRequest& request, std::vector<std::uint8_t> elements = {}) {
    if (masses_.empty()) place_.fail("the file has no atoms: check that this is the right file");
    Particles particles;
    particles.positions.resize(masses_.size());
    if (elements.empty()) elements = guessed_elements(particles.facts);
    if (std::ranges::count(elements, 0) < std::ssize(elements)) {
      particles.elements = std::move(elements);
    }
    particles.atom_names = names_.finish();
    particles.types = types_.finish();
    particles.residue_names = residues_.finish();
    particles.chains = chains_.finish();
    particles.residue_numbers = std::move(residue_numbers_);
    particles.insertion_codes = insertions_.values(particles.count());
    if (request.wants("charge")) particles.numbers.push_back({"charge", std::move(charges_)});
    if (request.wants("mass")) particles.numbers.push_back({"mass", std::move(masses_)});
    return particles;
  }

 private:
  /// Guesses elements. Particles lighter than any atom are virtual sites or the shells of
  /// polarizable atoms. The mass of a shell is missing in the mass of its atom. Notes count guesses
  /// and unknown elements.
  std::vector<std::uint8_t> guessed_elements(ParticleFacts& facts) const {
    constexpr double lightest = 1;
    std::vector<std::uint8_t> elements = elements_of_masses(masses_);
    std::uint64_t by_mass = 0;
    std::uint64_t by_name = 0;
    std::uint64_t unknown = 0;
    for (std::size_t i = 0; i < elements.size(); ++i) {
      by_mass += elements[i] != 0 ? 1 : 0;
      if (elements[i] != 0 || masses_[i] < lightest) continue;
      elements[i] = guess_element({residues_.column().of(i), names_.column().of(i)});
      by_name += elements[i] != 0 ? 1 : 0;
      const bool site = is_virtual_site(residues_.column().of(i), names_.column().of(i), 0);
      unknown += elements[i] == 0 && !site ? 1 : 0;
    }
    add_note(facts.notes, guessed_elements_note(by_mass, "guessed from masses"));
    add_note(facts.notes,
             guessed_elements_note(by_name, "guessed from names of atoms and residues"));
    add_note(facts.notes, unknown_elements_note(unknown));
    return elements;
  }

  const FilePlace& place_;
  NameIndex names_;
  NameIndex types_;
  NameIndex residues_;
  NameIndex chains_;
  std::vector<std::int32_t> residue_numbers_;
  SparseColumn<char> insertions_{' '};
  std::vector<double> charges_;
  std::vector<double> masses_;
};

}  // namespace parray::input
