#include "cli/input/formats/atom_columns.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include "cli/input/particles/elements.h"
#include "cli/input/particles/guess_element.h"
#include "cli/input/particles/residues.h"

namespace parray::input {
namespace {

constexpr std::uint8_t to_be_guessed = 255;

/// What a function says of each pair of residue name and atom name, asked once a pair.
template <typename Value, typename Ask>
class PerName {
 public:
  PerName(const NameColumn& residues, const NameColumn& names, Ask ask)
      : residues_(residues), names_(names), ask_(std::move(ask)) {}

  const Value& of(std::size_t particle, bool two_letters) {
    const std::uint64_t key = (std::uint64_t{residues_.index[particle]} << 33U) |
                              (std::uint64_t{names_.index[particle]} << 1U) |
                              (two_letters ? 1U : 0U);
    const auto known = values_.find(key);
    if (known != values_.end()) return known->second;
    return values_.emplace(key, ask_(residues_.of(particle), names_.of(particle), two_letters))
        .first->second;
  }

 private:
  const NameColumn& residues_;
  const NameColumn& names_;
  Ask ask_;
  std::unordered_map<std::uint64_t, Value> values_;
};

template <typename Value, typename Ask>
PerName<Value, Ask> per_name(const NameColumn& residues, const NameColumn& names, Ask ask) {
  return {residues, names, std::move(ask)};
}

/// The element, where a file gives an atom of a polymer or water the symbol that its name seems to
/// start with: "Ca" of CA in ALA.
struct Mended {
  std::uint8_t from = 0;  ///< 0: nothing to mend
  std::uint8_t to = 0;
};

Mended mended(const std::string& residue, const std::string& name, bool /*two_letters*/) {
  const bool known = is_water(residue) || is_amino_acid(residue) || is_nucleotide(residue);
  if (!known || name.size() < 2 || residue == "UNK") return {};
  const std::uint8_t from = atomic_number_of(std::string_view(name).substr(0, 2));
  const std::uint8_t to = guess_element({residue, name});
  return to == 0 || to == from ? Mended{} : Mended{from, to};
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
  if (atom.two_letters) {
    two_letters_.resize(index + 1);
    two_letters_[index] = 1;
    flush_left_ = flush_left_ || shows_flush_left(atom.residue_name, atom.name);
  }
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

void AtomColumns::note(std::string key, std::uint64_t count, std::string text) {
  if (count > 0) notes_.push_back({std::move(key), count, std::move(text)});
}

void AtomColumns::guess_elements() {
  auto guesses = per_name<std::uint8_t>(
      residue_names_.column(), atom_names_.column(),
      [](const std::string& residue, const std::string& name, bool two_letters) {
        return guess_element({residue, name, two_letters});
      });
  auto sites = per_name<bool>(residue_names_.column(), atom_names_.column(),
                              [](const std::string& residue, const std::string& name, bool) {
                                return is_virtual_site(residue, name, 0);
                              });
  std::uint64_t guessed = 0;
  std::uint64_t unknown = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    if (elements_[i] == to_be_guessed) {
      const bool two = !flush_left_ && i < two_letters_.size() && two_letters_[i] != 0;
      elements_[i] = guesses.of(i, two);
      guessed += elements_[i] != 0 ? 1 : 0;
    }
    if (elements_[i] == 0 && !sites.of(i, false)) ++unknown;
  }
  note("guessed_elements", guessed, "elements guessed from names of atoms and residues");
  note("unknown_elements", unknown, "particles of unknown element");
}

void AtomColumns::mend_elements() {
  auto remedies = per_name<Mended>(residue_names_.column(), atom_names_.column(), mended);
  std::uint64_t changed = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const std::uint8_t stated = elements_[i];
    if (stated == to_be_guessed || element(stated).symbol.size() < 2) continue;
    const Mended& remedy = remedies.of(i, false);
    if (remedy.from != stated) continue;
    elements_[i] = remedy.to;
    ++changed;
  }
  note("mended_elements", changed,
       "elements corrected: the file takes the first letters of names in proteins, nucleic acids "
       "or water for symbols");
}

/// Where the file has no types: the elements' symbols; without elements, the names.
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

void AtomColumns::fill_radii(Particles& particles) const {
  for (const std::size_t i : without_radius_) particles.radii[i] = element(elements_[i]).radius;
}

Particles AtomColumns::complete(Particles particles) {
  note("zero_radii", without_radius_.size(), "radii of 0 replaced by van der Waals radii");
  fill_radii(particles);
  ParticleMask mask;
  const bool choose =
      choice_.rule != AlternativeChoice::Rule::all && !alternatives_.letters.empty();
  if (choose) {
    const AtomIdentity atoms{residue_names_, atom_names_.column().index, chains_.column().index,
                             residue_numbers_};
    mask = chosen_locations(alternatives_, atoms, choice_);
  }
  if (!residue_names_.unnamed()) particles.residue_numbers = std::move(residue_numbers_);
  particles.atom_names = atom_names_.finish();
  particles.residue_names = residue_names_.finish();
  particles.chains = chains_.finish();
  if (choose) {
    const auto left_out = static_cast<std::uint64_t>(std::ranges::count(mask, 0));
    note("alternatives", left_out, "alternative locations left out");
    if (left_out > 0) keep(particles, mask);
  }
  particles.facts.notes = std::move(notes_);
  return particles;
}

Particles AtomColumns::finish_frame() {
  settle_doubtful(alternatives_, {residue_names_, atom_names_.column().index,
                                  chains_.column().index, residue_numbers_});
  if (doubt_elements_) mend_elements();
  guess_elements();
  name_types();
  return complete(columns_.finish_frame());
}

Particles AtomColumns::finish() {
  if (count() == 0) place_->fail("no particles: is this the right file?");
  return finish_frame();
}

}  // namespace parray::input
