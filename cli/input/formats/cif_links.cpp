#include "cli/input/formats/cif_links.h"

#include <map>
#include <tuple>
#include <utility>

#include "cli/input/formats/atom_columns.h"
#include "cli/input/formats/bond_fields.h"
#include "cli/input/particles/stated_bonds.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

constexpr std::string_view links_prefix = "_struct_conn_";
constexpr std::string_view types_prefix = "_struct_conn_type_";
constexpr std::string_view component_prefix = "_chem_comp_bond_";
constexpr std::string_view kind_tag = "_struct_conn_conn_type_id";

using Tag = std::pair<std::string_view, std::string CifLinkEnd::*>;

/// Tags of the dictionary mmcif_pdbx, with '#' for the number of the atom.
constexpr std::array<Tag, 10> end_tags{{
    {"_struct_conn_ptnr#_label_atom_id", &CifLinkEnd::name},
    {"_struct_conn_ptnr#_label_asym_id", &CifLinkEnd::label_chain},
    {"_struct_conn_ptnr#_label_seq_id", &CifLinkEnd::label_number},
    {"_struct_conn_ptnr#_label_alt_id", &CifLinkEnd::alternative},
    {"_struct_conn_ptnr#_auth_asym_id", &CifLinkEnd::chain},
    {"_struct_conn_ptnr#_auth_seq_id", &CifLinkEnd::residue_number},
    {"_struct_conn_pdbx_ptnr#_pdb_ins_code", &CifLinkEnd::insertion},
    {"_struct_conn_pdbx_ptnr#_label_alt_id", &CifLinkEnd::alternative},
    {"_struct_conn_ptnr#_symmetry", &CifLinkEnd::symmetry},
    {"_chem_comp_bond_atom_id_#", &CifLinkEnd::name},
}};

/// Finds particles by names. Looks for all of them in one pass.
class NamedParticles {
 public:
  explicit NamedParticles(const Particles& particles) : particles_(particles) {}

  void want(const CifLinkEnd& end) {
    if (const auto key = key_of(end)) found_[*key];
  }
  void search() {
    for (std::size_t i = 0; i < particles_.count(); ++i) {
      const auto known = found_.find(key_of(i));
      if (known != found_.end()) known->second.push_back(i);
    }
  }
  /// Returns the only particle that fits. Returns nothing if there is none or there are several.
  [[nodiscard]] std::optional<std::size_t> find(const CifLinkEnd& end) const {
    const auto key = key_of(end);
    if (!key) return {};
    std::optional<std::size_t> particle;
    for (const std::size_t i : found_.at(*key)) {
      if (!is_location(i, end.alternative)) continue;
      if (particle) return {};
      particle = i;
    }
    return particle;
  }

 private:
  using Key = std::tuple<std::size_t, std::size_t, std::int32_t, char>;

  static std::optional<std::size_t> number_of(const std::string& name, const NameColumn& column) {
    if (column.empty()) return 0;
    return place_in(column.names, name);
  }
  [[nodiscard]] std::optional<Key> key_of(const CifLinkEnd& end) const {
    const auto name = number_of(end.name, particles_.atom_names);
    const auto chain =
        number_of(end.chain.empty() ? end.label_chain : end.chain, particles_.chains);
    const auto residue =
        residue_number_in(end.residue_number.empty() ? end.label_number : end.residue_number);
    if (!name || !chain || !residue) return {};
    const bool codes = !particles_.insertion_codes.empty() && !end.insertion.empty();
    return Key(*name, *chain, particles_.residue_numbers.empty() ? 0 : *residue,
               codes ? end.insertion[0] : ' ');
  }
  [[nodiscard]] Key key_of(std::size_t i) const {
    const auto in = [i](const auto& column) { return column.empty() ? 0 : column[i]; };
    const char code = particles_.insertion_codes.empty() ? ' ' : particles_.insertion_codes[i];
    return Key(in(particles_.atom_names.index), in(particles_.chains.index),
               in(particles_.residue_numbers), code);
  }
  [[nodiscard]] bool is_location(std::size_t i, const std::string& letter) const {
    const std::vector<char>& letters = particles_.alternatives;
    return letters.empty() || letters[i] == ' ' || letter.empty() || letters[i] == letter[0];
  }

  const Particles& particles_;
  std::map<Key, std::vector<std::size_t>> found_;
};

}  // namespace

bool CifLinks::is_table(std::string_view plain_tag) {
  return plain_tag.starts_with(component_prefix) ||
         (plain_tag.starts_with(links_prefix) && !plain_tag.starts_with(types_prefix));
}

void CifLinks::start(const std::vector<std::string>& tags) {
  component_ = tags[0].starts_with(component_prefix);
  columns_.clear();
  next_ = 0;
  for (const std::string& tag : tags) {
    Column column;
    column.kind = tag == kind_tag;
    for (const auto& [pattern, member] : end_tags) {
      std::string wanted(pattern);
      for (std::size_t end = 0; end < 2; ++end) {
        wanted[pattern.find('#')] = end == 0 ? '1' : '2';
        if (tag == wanted) column = {member, end, false};
      }
    }
    columns_.push_back(column);
  }
}

void CifLinks::add(std::string value) {
  if (next_ == 0) links_.emplace_back().component = component_;
  Link& link = links_.back();
  const Column& column = columns_[next_];
  if (column.kind) link.kind = lower_case(value);
  if (column.member != nullptr) link.ends.at(column.end).*column.member = std::move(value);
  next_ = next_ + 1 == columns_.size() ? 0 : next_ + 1;
}

bool CifLinks::is_bond(const Link& link) {
  const bool known = link.component || link.kind.starts_with("covale") || link.kind == "disulf" ||
                     link.kind == "metalc";
  return known && link.ends[0].symmetry == link.ends[1].symmetry;
}

void CifLinks::finish(bool component, Particles& particles) const {
  NamedParticles named(particles);
  std::vector<const Link*> bonds;
  for (const Link& link : links_) {
    if (link.component != component || !is_bond(link)) continue;
    bonds.push_back(&link);
    for (const CifLinkEnd& end : link.ends) named.want(end);
  }
  if (bonds.empty()) return;
  named.search();
  std::uint64_t unknown = 0;
  for (const Link* link : bonds) {
    const auto first = named.find(link->ends[0]);
    const auto second = named.find(link->ends[1]);
    if (first && second && *first != *second) {
      particles.bonds.push_back(bond_between(*first, *second));
    } else {
      ++unknown;
    }
  }
  put_in_order(particles.bonds);
  particles.all_bonds = component && !particles.bonds.empty();
  if (unknown > 0) particles.facts.notes.push_back(unknown_bonds_note(unknown));
}

}  // namespace parray::input
