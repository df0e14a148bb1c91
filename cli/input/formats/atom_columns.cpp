#include "cli/input/formats/atom_columns.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <utility>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/guess_element.h"
#include "cli/input/particles/residues.h"
#include "cli/input/particles/stated_bonds.h"
#include "common/base/ascii.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

/// The columns that identify an atom.
struct AtomIdentity {
  /// Chain, residue number and insertion code.
  using ResidueKey = std::tuple<std::uint32_t, std::int32_t, char>;

  AlternativeColumns& alternatives;
  NameIndex& residue_names;
  const std::vector<std::uint32_t>& atom_names;  ///< numbers of the names, one per particle
  const std::vector<std::uint32_t>& chains;
  const std::vector<std::int32_t>& residue_numbers;

  [[nodiscard]] ResidueKey residue_of(std::size_t i) const {
    return {chains[i], residue_numbers[i], alternatives.insertions.at(i)};
  }
  /// Returns whether `other` is an atom of the same residue as `particle`.
  [[nodiscard]] bool same_residue(std::size_t particle, std::size_t other) const {
    const auto& names = residue_names.column().index;
    return other < names.size() && names[other] == names[particle] &&
           residue_of(other) == residue_of(particle);
  }
};

/// Returns the end of the run of doubtful atoms from `begin` on that are consecutive and in one
/// residue.
std::size_t run_end(const AtomIdentity& atoms, std::size_t begin) {
  const auto& doubtful = atoms.alternatives.doubtful;
  std::size_t end = begin + 1;
  while (end < doubtful.size() && doubtful[end] == doubtful[end - 1] + 1 &&
         atoms.same_residue(doubtful[begin], doubtful[end])) {
    ++end;
  }
  return end;
}

bool are_locations(const AtomIdentity& atoms, std::size_t first, std::size_t last) {
  if (atoms.same_residue(first, last + 1)) return true;
  if (first > 0 && atoms.same_residue(first, first - 1)) return true;
  const char letter = atoms.alternatives.letters.at(first);
  for (std::size_t i = first; i <= last; ++i) {
    const float occupancy = atoms.alternatives.occupancies.at(i);
    if (atoms.alternatives.letters.at(i) != letter || (occupancy > 0 && occupancy < 1)) return true;
  }
  return false;
}

/// Handles doubtful letters. If such a letter is the only one in its residue and the occupancies do
/// not indicate alternatives, it is the first letter of the residue's name.
void settle_doubtful(const AtomIdentity& atoms) {
  const auto& doubtful = atoms.alternatives.doubtful;
  for (std::size_t begin = 0; begin < doubtful.size();) {
    const std::size_t end = run_end(atoms, begin);
    const std::size_t first = doubtful[begin];
    const std::size_t last = doubtful[end - 1];
    begin = end;
    if (are_locations(atoms, first, last)) continue;
    const std::string name =
        atoms.alternatives.letters.at(first) + atoms.residue_names.column().of(first);
    for (std::size_t i = first; i <= last; ++i) {
      atoms.residue_names.rename(i, name);
      atoms.alternatives.letters.reset(i);
    }
  }
  if (!doubtful.empty()) atoms.residue_names.drop_unused();
}

/// Returns the atoms that stay. Locations of one atom share chain, residue and name but have
/// different letters. Atoms that also share the letter all stay. If the locations belong to
/// different residues (a mutant next to the wild type), the function first chooses a residue.
ParticleMask chosen_locations(const AtomIdentity& atoms, const AlternativeChoice& choice) {
  using ResidueKey = AtomIdentity::ResidueKey;
  using AtomKey = std::tuple<ResidueKey, std::uint32_t, std::uint32_t>;
  const auto& letters = atoms.alternatives.letters;
  const auto& occupancies = atoms.alternatives.occupancies;
  const auto& names = atoms.residue_names.column().index;
  const std::size_t count = names.size();
  Choices<ResidueKey, std::uint32_t> residues(choice);  // by number of the name
  for (std::size_t i = 0; i < count; ++i) {
    const char letter = letters.at(i);
    if (letter == ' ') continue;
    residues.offer(atoms.residue_of(i), {&letter, 1}, occupancies.at(i), names[i]);
  }
  Choices<AtomKey, char> locations(choice);  // by letter
  for (std::size_t i = 0; i < count; ++i) {
    const ResidueKey residue = atoms.residue_of(i);
    const char letter = letters.at(i);
    if (!residues.has(residue)) continue;
    locations.offer({residue, names[i], atoms.atom_names[i]}, {&letter, 1}, occupancies.at(i),
                    letter);
  }
  ParticleMask mask(count, 1);
  for (std::size_t i = 0; i < count; ++i) {
    const ResidueKey residue = atoms.residue_of(i);
    const char letter = letters.at(i);
    if (!residues.has(residue)) continue;
    const bool other_residue = letter != ' ' && names[i] != residues.of(residue);
    const bool other_location = letter != locations.of({residue, names[i], atoms.atom_names[i]});
    if (other_residue || other_location) mask[i] = 0;
  }
  return mask;
}

constexpr std::uint8_t to_be_guessed = 255;

/// The element of a name. `certain`: the columns of PDB give it.
struct ElementGuess {
  std::uint8_t element = 0;
  bool certain = false;
};

/// Caches the result of a function for each pair of residue name and atom name.
template <typename Ask>
class PerName {
 public:
  PerName(const NameColumn& residues, const NameColumn& names, Ask ask)
      : residues_(residues), names_(names), ask_(std::move(ask)) {}

  const auto& of(std::size_t particle, bool two_letters) {
    const std::uint64_t key = (std::uint64_t{residues_.index[particle]} << 33U) |
                              (std::uint64_t{names_.index[particle]} << 1U) |
                              (two_letters ? 1U : 0U);
    const auto [known, fresh] = values_.try_emplace(key);
    if (fresh) known->second = ask_(residues_.of(particle), names_.of(particle), two_letters);
    return known->second;
  }

 private:
  using Value = std::invoke_result_t<Ask, const std::string&, const std::string&, bool>;

  const NameColumn& residues_;
  const NameColumn& names_;
  Ask ask_;
  std::unordered_map<std::uint64_t, Value> values_;
};

/// A correction for a file that takes the first letters of an atom's name in a polymer or water as
/// its symbol: "Ca" for CA in ALA.
struct Mended {
  std::uint8_t from = 0;  ///< 0: no correction
  std::uint8_t to = 0;
};

Mended mended(const std::string& residue, const std::string& name, bool /*two_letters*/) {
  const bool known = is_water(residue) || is_amino_acid(residue) || is_nucleotide(residue);
  if (!known || name.size() < 2 || residue == "UNK") return {};
  const std::uint8_t from = atomic_number_of(std::string_view(name).substr(0, 2));
  const std::uint8_t to = guess_element({residue, name});
  return to == 0 || to == from ? Mended{} : Mended{from, to};
}

/// Parses hybrid-36, in which A0...0 (base 36) follows 9...9.
std::optional<std::int64_t> hybrid_36_in(std::string_view text) {
  constexpr int base = 36;
  for (const char c : text) {
    if (!ascii::is_upper(c) && !ascii::is_digit(c)) return {};
  }
  const auto value = parsed<std::int64_t>(text, base);
  if (!value) return {};
  std::int64_t first = 10;    // A0...0 in base 36
  std::int64_t decimal = 10;  // the number that it means
  for (std::size_t i = 1; i < text.size(); ++i) {
    first *= base;
    decimal *= 10;
  }
  return *value - first + decimal;
}

/// Parses a number of at most `longest` characters: decimal, hybrid-36 of `hybrid_width` characters
/// or hexadecimal.
std::optional<std::int64_t> overflowing_number_in(std::string_view text, std::size_t longest,
                                                  std::size_t hybrid_width) {
  if (text.starts_with('+')) text.remove_prefix(1);
  if (text.empty() || text.size() > longest) return {};
  std::optional<std::int64_t> value = parsed<std::int64_t>(text);
  if (!value && text.size() == hybrid_width && ascii::is_upper(text[0])) value = hybrid_36_in(text);
  if (!value && text[0] != '-') value = parsed<std::int64_t>(text, 16);
  return value;
}

}  // namespace

AtomColumns::AtomColumns(const FilePlace& place, const ParticleRequest& request,
                         std::initializer_list<const char*> names)
    : place_(&place), choice_(request.alternatives), columns_(place) {
  for (const char* name : names) {
    const bool wanted = request.wants(name);
    number_columns_.push_back(wanted ? std::optional(columns_.add_numbers(name)) : std::nullopt);
  }
}

void AtomColumns::add(const Atom& atom) {
  const std::size_t index = count();
  columns_.position(atom.position);
  elements_.push_back(atom.element.value_or(to_be_guessed));
  atom_names_.add(atom.name, *place_);
  residue_names_.add(atom.residue_name, *place_);
  chains_.add(atom.chain, *place_);
  types_.add(atom.type, *place_);
  own_types_ = own_types_ || !atom.type.empty();
  residue_numbers_.push_back(atom.residue_number);
  two_letters_.set(index, atom.two_letters ? 1 : 0);
  flush_left_ = flush_left_ || (atom.two_letters && shows_flush_left(atom.residue_name, atom.name));
  alternatives_.letters.set(index, atom.alternative);
  alternatives_.insertions.set(index, atom.insertion);
  if (std::isfinite(atom.occupancy)) {
    alternatives_.occupancies.set(index, static_cast<float>(atom.occupancy));
  }
  if (atom.doubtful_alternative) alternatives_.doubtful.push_back(index);
}

void AtomColumns::numbers(std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (number_columns_[i]) columns_.number(*number_columns_[i], values[i]);
  }
}

void AtomColumns::radius(double radius) {
  if (radius == 0) without_radius_.push_back(count() - 1);
  columns_.radius(radius == 0 ? 1 : radius);
}

void AtomColumns::guess_elements() {
  PerName guesses(residue_names_.column(), atom_names_.column(),
                  [](const std::string& residue, const std::string& name, bool two_letters) {
                    const AtomName atom{residue, name, two_letters};
                    return ElementGuess{guess_element(atom), element_of_columns(atom) != 0};
                  });
  PerName sites(residue_names_.column(), atom_names_.column(),
                [](const std::string& residue, const std::string& name, bool /*two_letters*/) {
                  return is_virtual_site(residue, name, 0);
                });
  std::uint64_t guessed = 0;
  std::uint64_t unknown = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    if (elements_[i] == to_be_guessed) {
      const bool two = !flush_left_ && two_letters_.at(i) != 0;
      const ElementGuess& guess = guesses.of(i, two);
      elements_[i] = guess.element;
      guessed += guess.element != 0 && !guess.certain ? 1 : 0;
    }
    if (elements_[i] == 0 && !sites.of(i, false)) ++unknown;
  }
  note(guessed_elements_note(guessed, "guessed from names of atoms and residues"));
  note(unknown_elements_note(unknown));
}

void AtomColumns::mend_elements() {
  PerName remedies(residue_names_.column(), atom_names_.column(), mended);
  std::uint64_t changed = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const std::uint8_t stated = elements_[i];
    if (stated == to_be_guessed || element(stated).symbol.size() < 2) continue;
    const Mended& remedy = remedies.of(i, false);
    if (remedy.from != stated) continue;
    elements_[i] = remedy.to;
    ++changed;
  }
  note({"mended_elements", changed,
        in_number(changed, "element", "elements") +
            " corrected: the file uses the first letters of atom names in proteins, nucleic "
            "acids or water as symbols"});
}

/// Sets the types of a file without types: the elements' symbols or, without elements, the atom
/// names.
void AtomColumns::name_types() {
  const bool any = std::ranges::any_of(elements_, [](std::uint8_t e) { return e != 0; });
  for (std::size_t i = 0; i < count(); ++i) {
    columns_.element(elements_[i]);
    if (own_types_) {
      columns_.type(types_.column().of(i));
    } else if (any) {
      columns_.type(element(elements_[i]).symbol);
    } else {
      columns_.type(atom_names_.column().of(i));
    }
  }
}

/// Adds what ParticleColumns does not hold. `mask`: the chosen locations; empty: all.
Particles AtomColumns::complete(Particles particles, const ParticleMask& mask) {
  note({"zero_radii", without_radius_.size(),
        in_number(without_radius_.size(), "radius of 0 replaced by the van der Waals radius",
                  "radii of 0 replaced by van der Waals radii")});
  for (const std::size_t i : without_radius_) particles.radii[i] = element(elements_[i]).radius;
  put_in_order(bonds_);
  particles.bonds = std::move(bonds_);
  particles.all_bonds = all_bonds_ && !particles.bonds.empty();
  if (choice_.rule == AlternativeChoice::Rule::all) {
    particles.alternatives = alternatives_.letters.values(particles.count());
  }
  if (!residue_names_.unnamed()) {
    particles.residue_numbers = std::move(residue_numbers_);
    particles.insertion_codes = alternatives_.insertions.values(particles.count());
  }
  particles.atom_names = atom_names_.finish();
  particles.residue_names = residue_names_.finish();
  particles.chains = chains_.finish();
  if (!mask.empty()) {
    const auto left_out = static_cast<std::uint64_t>(std::ranges::count(mask, 0));
    note({"alternatives", left_out,
          in_number(left_out, "alternative location", "alternative locations") + " left out"});
    if (left_out > 0) keep(particles, mask);
    particles.indices.clear();  // `index` does not count locations that are left out
  }
  particles.facts.notes = std::move(notes_);
  return particles;
}

Particles AtomColumns::finish_frame() {
  const AtomIdentity atoms{alternatives_, residue_names_, atom_names_.column().index,
                           chains_.column().index, residue_numbers_};
  settle_doubtful(atoms);
  ParticleMask mask;
  if (choice_.rule != AlternativeChoice::Rule::all && !alternatives_.letters.empty()) {
    mask = chosen_locations(atoms, choice_);
  }
  if (doubt_elements_) mend_elements();
  guess_elements();
  name_types();
  return complete(columns_.finish_frame(), mask);
}

Particles AtomColumns::finish() {
  if (count() == 0) place_->fail("the file has no particles: check that this is the right file");
  return finish_frame();
}

std::optional<std::uint8_t> element_of_listed(std::span<const TypesOfElement> lists,
                                              std::string_view type) {
  const std::string word = " " + std::string(type) + " ";
  for (const TypesOfElement& list : lists) {
    if (list.types.find(word) != std::string_view::npos) return list.element;
  }
  return {};
}

std::optional<std::int32_t> residue_number_in(std::string_view text) {
  const std::optional<std::int64_t> value = overflowing_number_in(text, 6, 4);
  if (!value) return {};
  return static_cast<std::int32_t>(*value);
}

std::optional<std::int64_t> serial_number_in(std::string_view text) {
  return overflowing_number_in(text, 9, 5);
}

}  // namespace parray::input
