#include "cli/input/formats/cif_row.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "cli/input/formats/gemmi_seam.h"
#include "cli/input/particles/particle_text.h"

namespace parray::input {
namespace {

using Name = std::pair<std::string_view, CifItem>;

/// Of the dictionaries mmcif_pdbx, cif_core (both forms) and that of CCP4's monomer library.
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
  const auto* const found =
      std::ranges::find_if(known_items, [&](const Name& name) { return name.first == tag; });
  return found == known_items.end() ? CifItem::count : found->second;
}

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
    CifItem item = item_of(tag);
    if (item != CifItem::count && has(item)) item = CifItem::count;  // the first of two counts
    items_.push_back(item);
    if (item != CifItem::count) has_[static_cast<std::size_t>(item)] = true;
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
  constexpr std::array<std::string_view, 9> axes{"cartn_x",
                                                 "cartn_y",
                                                 "cartn_z",
                                                 "fract_x",
                                                 "fract_y",
                                                 "fract_z",
                                                 "pdbx_model_cartn_x_ideal",
                                                 "pdbx_model_cartn_y_ideal",
                                                 "pdbx_model_cartn_z_ideal"};
  return axes[static_cast<std::size_t>(item)];
}

double CifRow::number(CifItem item, const FilePlace& place) const {
  const std::string& text = texts_[static_cast<std::size_t>(item)];
  return number_field(without_uncertainty(text), axis_name(item), place);
}

double CifRow::number_or_unknown(CifItem item) const {
  return number_in(without_uncertainty(text(item)))
      .value_or(std::numeric_limits<double>::quiet_NaN());
}

std::string_view without_uncertainty(std::string_view value) {
  return value.substr(0, value.find('('));
}

}  // namespace parray::input
