#include "cli/input/formats/cif_atoms.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include "cli/input/formats/gemmi_seam.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/frames.h"
#include "cli/input/particles/guess_element.h"
#include "common/base/ascii.h"
#include "common/base/text.h"

namespace parray::input {
namespace {

using Name = std::pair<std::string_view, CifItem>;

/// The tags of the dictionaries mmcif_pdbx, cif_core (both forms) and CCP4's monomer library.
constexpr std::array<Name, 42> known_items{{
    {"_atom_site_cartn_x", CifItem::x},
    {"_atom_site_cartn_y", CifItem::y},
    {"_atom_site_cartn_z", CifItem::z},
    {"_atom_site_fract_x", CifItem::fract_x},
    {"_atom_site_fract_y", CifItem::fract_y},
    {"_atom_site_fract_z", CifItem::fract_z},
    {"_atom_site_type_symbol", CifItem::symbol},
    {"_atom_site_auth_asym_id", CifItem::auth_chain},
    {"_atom_site_label_asym_id", CifItem::label_chain},
    {"_atom_site_auth_seq_id", CifItem::auth_number},
    {"_atom_site_label_seq_id", CifItem::label_number},
    {"_atom_site_pdbx_pdb_ins_code", CifItem::insertion},
    {"_atom_site_auth_comp_id", CifItem::auth_residue},
    {"_atom_site_label_comp_id", CifItem::label_residue},
    {"_atom_site_auth_atom_id", CifItem::auth_name},
    {"_atom_site_label_atom_id", CifItem::label_name},
    {"_atom_site_label", CifItem::label_name},
    {"_atom_site_label_alt_id", CifItem::alternative},
    {"_atom_site_disorder_group", CifItem::alternative},
    {"_atom_site_disorder_assembly", CifItem::assembly},
    {"_atom_site_occupancy", CifItem::occupancy},
    {"_atom_site_b_iso_or_equiv", CifItem::b_factor},
    {"_atom_site_u_iso_or_equiv", CifItem::u_factor},
    {"_atom_site_pdbx_formal_charge", CifItem::charge},
    {"_atom_site_calc_flag", CifItem::calculated},
    {"_atom_site_pdbx_pdb_model_num", CifItem::model},
    {"_chem_comp_atom_model_cartn_x", CifItem::x},
    {"_chem_comp_atom_model_cartn_y", CifItem::y},
    {"_chem_comp_atom_model_cartn_z", CifItem::z},
    {"_chem_comp_atom_x", CifItem::x},
    {"_chem_comp_atom_y", CifItem::y},
    {"_chem_comp_atom_z", CifItem::z},
    {"_chem_comp_atom_pdbx_model_cartn_x_ideal", CifItem::ideal_x},
    {"_chem_comp_atom_pdbx_model_cartn_y_ideal", CifItem::ideal_y},
    {"_chem_comp_atom_pdbx_model_cartn_z_ideal", CifItem::ideal_z},
    {"_chem_comp_atom_type_symbol", CifItem::symbol},
    {"_chem_comp_atom_comp_id", CifItem::label_residue},
    {"_chem_comp_atom_atom_id", CifItem::label_name},
    {"_chem_comp_atom_charge", CifItem::charge},
    {"_chem_comp_atom_partial_charge", CifItem::charge},
    {"_chem_comp_atom_pdbx_component_comp_id", CifItem::auth_residue},
    {"_chem_comp_atom_alt_atom_id", CifItem::auth_name},
}};

CifItem item_of(std::string_view tag) {
  const auto* const found = std::ranges::find(known_items, tag, &Name::first);
  return found == known_items.end() ? CifItem::count : found->second;
}

/// Returns the element of a type symbol, which may have a suffix: "Fe3+", "O2-", "Cval".
std::uint8_t element_of_symbol(std::string_view type) {
  std::size_t letters = 0;
  while (letters < type.size() && ascii::is_letter(type[letters])) ++letters;
  const std::uint8_t two = letters == 2 ? atomic_number_of(type.substr(0, 2)) : 0;
  if (two != 0 || letters == 0) return two;
  const std::uint8_t cased =
      letters > 2 && type[1] >= 'a' ? atomic_number_of(type.substr(0, 2)) : 0;
  return cased != 0 ? cased : atomic_number_of(type.substr(0, 1));
}

/// Returns the position if the row has all three coordinates.
std::optional<Vec3d> position_of(const CifRow& row, CifItem x, const FilePlace& place) {
  const CifItem y = CifRow::after(x, 1);
  const CifItem z = CifRow::after(x, 2);
  if (row.text(x).empty() || row.text(y).empty() || row.text(z).empty()) return {};
  const double first = row.number(x, place);
  const double second = row.number(y, place);
  return Vec3d{first, second, row.number(z, place)};
}

char first_of(std::string_view text) { return text.empty() ? ' ' : text[0]; }

}  // namespace

std::string plain_tag(std::string_view tag) {
  std::string plain = lower_case(tag);
  std::ranges::replace(plain, '.', '_');
  return plain;
}

CifTable table_of(std::string_view plain_tag) {
  constexpr std::string_view anisotropic = "_atom_site_aniso";
  if (plain_tag.starts_with("_chem_comp_atom_")) return CifTable::components;
  const bool site = plain_tag.starts_with("_atom_site_") && !plain_tag.starts_with(anisotropic);
  return site ? CifTable::sites : CifTable::other;
}

void CifRow::start(const std::vector<std::string>& tags) {
  items_.clear();
  has_.fill(false);
  next_ = 0;
  for (const std::string& tag : tags) {
    const CifItem item = item_of(tag);
    const bool used = item != CifItem::count && !has(item);  // of two equal columns, the first
    items_.push_back(used ? item : CifItem::count);
    if (used) has_[static_cast<std::size_t>(item)] = true;
  }
}

std::string_view CifRow::text(CifItem item) const {
  if (!has(item)) return {};
  const auto at = static_cast<std::size_t>(item);
  const std::string& raw = texts_[at];
  if (raw == "." || raw == "?") return {};
  const bool quoted = !raw.empty() && (raw[0] == '\'' || raw[0] == '"' || raw[0] == ';');
  if (!quoted) return raw;
  unquoted_[at] = cif_text(raw);
  return unquoted_[at];
}

std::string_view CifRow::axis_name(CifItem item) {
  constexpr auto axes = std::to_array<std::string_view>(
      {"cartn_x", "cartn_y", "cartn_z", "fract_x", "fract_y", "fract_z", "pdbx_model_cartn_x_ideal",
       "pdbx_model_cartn_y_ideal", "pdbx_model_cartn_z_ideal"});
  return axes[static_cast<std::size_t>(item)];
}

double CifRow::number(CifItem item, const FilePlace& place) const {
  const std::string& text = texts_[static_cast<std::size_t>(item)];
  return number_field(without_uncertainty(text), axis_name(item), place);
}

double CifRow::number_or_unknown(CifItem item) const {
  return number_or_nan(without_uncertainty(text(item)));
}

std::string_view without_uncertainty(std::string_view value) {
  return value.substr(0, value.find('('));
}

void CifSites::start(CifTable table, const CifRow& row) {
  kind_ = table == CifTable::components ? Kind::component
          : row.has(CifItem::x)         ? Kind::cartesian
                                        : Kind::fractional;
}

void CifSites::add(const CifRow& row) {
  switch (kind_) {
    case Kind::cartesian: return add_cartesian(row);
    case Kind::fractional: return add_fractional(row);
    case Kind::component: return add_component(row);
    case Kind::none: break;
  }
}

/// Records new models. If the last model is wanted, discards the atoms of the previous one.
bool CifSites::in_chosen_model(const CifRow& row) {
  const std::string_view model = row.text(CifItem::model);
  const bool last = request_.frame && request_.frame->last;
  if (models_.empty() || models_[model_] != model) {
    const auto found = std::ranges::find(models_, model);
    model_ = static_cast<std::size_t>(found - models_.begin());
    if (found == models_.end()) {
      models_.emplace_back(model);
      if (last) {
        atoms_.reset();
        unplaced_ = 0;
      }
    }
  }
  return last ? model_ + 1 == models_.size() : model_ == request_.frame_number();
}

void CifSites::add_cartesian(const CifRow& row) {
  if (!in_chosen_model(row)) return;
  if (!atoms_) {
    atoms_.emplace(*place_, request_,
                   std::initializer_list<const char*>{"occupancy", "b_factor", "charge"});
  }
  const auto position = position_of(row, CifItem::x, *place_);
  if (!position) {
    ++unplaced_;
    return;
  }
  Atom atom;
  atom.position = *position;
  atom.name = row.text(CifItem::auth_name, CifItem::label_name);
  atom.residue_name = row.text(CifItem::auth_residue, CifItem::label_residue);
  atom.chain = row.text(CifItem::auth_chain, CifItem::label_chain);
  atom.residue_number =
      residue_number_in(row.text(CifItem::auth_number, CifItem::label_number)).value_or(0);
  atom.insertion = first_of(row.text(CifItem::insertion));
  atom.alternative = first_of(row.text(CifItem::alternative));
  const std::string_view symbol = row.text(CifItem::symbol);
  if (!symbol.empty()) atom.element = atomic_number_of(symbol);
  const double occupancy = row.number_or_unknown(CifItem::occupancy);
  atom.occupancy = occupancy;
  atoms_->add(atom);
  atoms_->numbers({{occupancy, row.number_or_unknown(CifItem::b_factor),
                    row.number_or_unknown(CifItem::charge)}});
}

void CifSites::add_fractional(const CifRow& row) {
  if (lower_case(row.text(CifItem::calculated)) == "dum") {
    ++dummies_;
    return;
  }
  const auto position = position_of(row, CifItem::fract_x, *place_);
  if (!position) {
    ++unplaced_;
    return;
  }
  CrystalSite site;
  site.fraction = *position;
  site.label = row.text(CifItem::label_name);
  const std::string_view symbol = row.text(CifItem::symbol);
  site.element =
      symbol.empty() ? guess_element({"", site.label, false, false}) : element_of_symbol(symbol);
  site.group = row.text(CifItem::alternative);
  if (site.group == "0") site.group.clear();
  site.assembly = row.text(CifItem::assembly);
  const double occupancy = row.number_or_unknown(CifItem::occupancy);
  site.occupancy = occupancy >= 0 ? occupancy : 1;
  constexpr double b_of_u = 8 * std::numbers::pi * std::numbers::pi;
  site.b_factor = row.has(CifItem::b_factor) ? row.number_or_unknown(CifItem::b_factor)
                                             : b_of_u * row.number_or_unknown(CifItem::u_factor);
  sites_.push_back(std::move(site));
}

void CifSites::add_component(const CifRow& row) {
  ComponentAtom atom;
  atom.name = row.text(CifItem::label_name, CifItem::auth_name);
  atom.residue = row.text(CifItem::label_residue, CifItem::auth_residue);
  atom.model = position_of(row, CifItem::x, *place_);
  atom.ideal = position_of(row, CifItem::ideal_x, *place_);
  atom.element = element_of_symbol(row.text(CifItem::symbol));
  atom.charge = row.number_or_unknown(CifItem::charge);
  component_.push_back(std::move(atom));
}

void CifSites::check_placed(std::size_t placed) const {
  if (placed > 0 || unplaced_ == 0) return;
  place_->fail(
      "no atom has three coordinates: replace each ? and . of the coordinates by a number");
}

Particles CifSites::finish_atoms(AtomColumns& atoms) const {
  check_placed(atoms.count());
  atoms.note({"unplaced", unplaced_,
              in_number(unplaced_, "atom", "atoms") + " without coordinates left out"});
  return atoms.finish();
}

Particles CifSites::finish_cartesian(const Crystal& crystal) {
  if (models_.empty()) place_->fail("the file has no particles: check that this is the right file");
  const bool last = request_.frame && request_.frame->last;
  const std::uint64_t frame = last ? models_.size() - 1 : request_.frame_number();
  if (!atoms_) fail_without_frame(*place_, models_.size(), frame);
  Particles particles = finish_atoms(*atoms_);
  const Vec3d& edges = crystal.lengths;
  const bool placeholder = edges.x == 1 && edges.y == 1 && edges.z == 1;  // as in PDB's CRYST1
  if (!placeholder) particles.cell = cell_from(edges, crystal.angles);
  particles.facts.frame = frame;
  if (last || request_.all) particles.facts.frames = models_.size();
  return particles;
}

/// Uses ideal coordinates if all atoms that have coordinates have ideal ones, otherwise those of
/// the model.
Particles CifSites::finish_component() {
  const auto all_ideal = std::ranges::all_of(component_, [](const ComponentAtom& atom) {
    return atom.ideal.has_value() || !atom.model.has_value();
  });
  AtomColumns atoms(*place_, request_, {"charge"});
  for (const ComponentAtom& from : component_) {
    const std::optional<Vec3d>& position = all_ideal ? from.ideal : from.model;
    if (!position) {
      ++unplaced_;
      continue;
    }
    atoms.add({.position = *position,
               .name = from.name,
               .residue_name = from.residue,
               .residue_number = 1,
               .element = from.element});
    atoms.numbers({{from.charge}});
  }
  return finish_atoms(atoms);
}

Particles CifSites::finish(Crystal& crystal) {
  if (kind_ == Kind::cartesian) return finish_cartesian(crystal);
  if (request_.frame && request_.frame->number > 0) {
    fail_without_frame(*place_, 1, request_.frame->number);
  }
  if (kind_ == Kind::component) return finish_component();
  check_placed(sites_.size() + dummies_);
  crystal.sites = std::move(sites_);
  Particles particles = unit_cell(std::move(crystal), request_, *place_);
  auto& notes = particles.facts.notes;
  add_note(notes, {"unplaced", unplaced_,
                   in_number(unplaced_, "site", "sites") + " without coordinates left out"});
  add_note(notes, {"left_out_dummies", dummies_,
                   in_number(dummies_, "dummy site", "dummy sites") + " left out"});
  return particles;
}

}  // namespace parray::input
