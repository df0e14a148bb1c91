#include "cli/input/formats/cif_sites.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include "cli/input/formats/atom_record.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/frames.h"
#include "cli/input/particles/guess_element.h"
#include "cli/input/particles/particle_text.h"
#include "common/base/ascii.h"

namespace parray::input {
namespace {

/// A type's symbol with what may follow it: "Fe3+", "O2-", "Cval".
std::uint8_t element_of_symbol(std::string_view type) {
  std::size_t letters = 0;
  while (letters < type.size() && ascii::is_letter(type[letters])) ++letters;
  const std::uint8_t two = letters == 2 ? atomic_number_of(type.substr(0, 2)) : 0;
  if (two != 0 || letters == 0) return two;
  const std::uint8_t cased =
      letters > 2 && type[1] >= 'a' ? atomic_number_of(type.substr(0, 2)) : 0;
  return cased != 0 ? cased : atomic_number_of(type.substr(0, 1));
}

/// All three are there.
std::optional<Vec3d> position_of(const CifRow& row, CifItem x, const FilePlace& place) {
  if (!row.has_position(x)) return {};
  const CifItem y = CifRow::after(x, 1);
  const CifItem z = CifRow::after(x, 2);
  if (row.text(x).empty() || row.text(y).empty() || row.text(z).empty()) return {};
  const double first = row.number(x, place);
  const double second = row.number(y, place);
  return Vec3d{first, second, row.number(z, place)};
}

char first_of(std::string_view text) { return text.empty() ? ' ' : text[0]; }

}  // namespace

void CifSites::start(CifTable table, const CifRow& row) {
  if (table == CifTable::components) {
    kind_ = Kind::component;
  } else {
    kind_ = row.has_position(CifItem::x) ? Kind::cartesian : Kind::fractional;
  }
}

void CifSites::add(const CifRow& row) {
  switch (kind_) {
    case Kind::cartesian:
      return add_cartesian(row);
    case Kind::fractional:
      return add_fractional(row);
    case Kind::component:
      return add_component(row);
    case Kind::none:
      break;
  }
}

/// Notes new models, and begins anew at each where the last one is wanted.
bool CifSites::in_chosen_model(const CifRow& row) {
  const std::string_view model = row.text(CifItem::model);
  const bool last = request_.frame && request_.frame->last;
  if (models_.empty() || models_[model_] != model) {
    const auto found = std::ranges::find(models_, model);
    model_ = static_cast<std::size_t>(found - models_.begin());
    if (found == models_.end()) {
      models_.emplace_back(model);
      if (last) atoms_.reset();
    }
  }
  return last ? model_ + 1 == models_.size() : model_ == request_.frame_number();
}

void CifSites::add_cartesian(const CifRow& row) {
  if (!in_chosen_model(row)) return;
  if (!atoms_)
    atoms_.emplace(*place_, request_,
                   std::initializer_list<const char*>{"occupancy", "b_factor", "charge"});
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
  if (const std::uint8_t element = atomic_number_of(symbol); element != 0 || !symbol.empty()) {
    atom.element = element;
  }
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

Particles CifSites::finish_cartesian(const Crystal& crystal) {
  if (models_.empty()) place_->fail("no particles: is this the right file?");
  const bool last = request_.frame && request_.frame->last;
  const std::uint64_t frame = last ? models_.size() - 1 : request_.frame_number();
  if (!atoms_) fail_without_frame(*place_, models_.size(), frame);
  atoms_->note("unplaced", unplaced_, "atoms without coordinates left out");
  Particles particles = atoms_->finish();
  const Vec3d& edges = crystal.lengths;
  const bool dummy = edges.x == 1 && edges.y == 1 && edges.z == 1;  // as in PDB's CRYST1
  if (!dummy) particles.cell = cell_from(edges, crystal.angles);
  particles.facts.frame = frame;
  if (last || request_.all) particles.facts.frames = models_.size();
  return particles;
}

/// Ideal coordinates, where all atoms that have any have them, else those of the model.
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
    Atom atom;
    atom.position = *position;
    atom.name = from.name;
    atom.residue_name = from.residue;
    atom.residue_number = 1;
    atom.element = from.element;
    atoms.add(atom);
    atoms.numbers({{from.charge}});
  }
  atoms.note("unplaced", unplaced_, "atoms without coordinates left out");
  return atoms.finish();
}

Particles CifSites::finish(Crystal& crystal) {
  if (kind_ == Kind::cartesian) return finish_cartesian(crystal);
  if (request_.frame && request_.frame->number > 0) {
    fail_without_frame(*place_, 1, request_.frame->number);
  }
  if (kind_ == Kind::component) return finish_component();
  crystal.sites = std::move(sites_);
  Particles particles = unit_cell(std::move(crystal), request_, *place_);
  auto& notes = particles.facts.notes;
  if (unplaced_ > 0) notes.push_back({"unplaced", unplaced_, "sites without coordinates left out"});
  if (dummies_ > 0) notes.push_back({"left_out_dummies", dummies_, "dummy sites left out"});
  return particles;
}

}  // namespace parray::input
