#include "cli/input/particles/drawn_bonds.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "cli/input/particles/bonds.h"
#include "cli/input/particles/cell.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/particle_summary.h"
#include "cli/input/particles/residues.h"
#include "cli/input/particles/stated_bonds.h"
#include "cli/input/select/neighbour_grid.h"

namespace parray::input {
namespace {

constexpr double least_distance = 0.5;  // angstrom, of two atoms

using Bonds = std::vector<PeriodicBond>;

/// Finds the vectors of bonds.
class Images {
 public:
  explicit Images(const Particles& particles) : particles_(particles) {
    if (particles.cell) fractions_.emplace(*particles.cell);
  }

  [[nodiscard]] CellImage nearest(std::uint32_t from, std::uint32_t to) const {
    if (!fractions_) return {};
    return fractions_->nearest(particles_.positions[from], particles_.positions[to]);
  }

  /// Returns the vector from one atom to the image of the other.
  [[nodiscard]] Vec3d delta(const PeriodicBond& bond) const {
    const Vec3d direct = particles_.positions[bond.to] - particles_.positions[bond.from];
    return bond.image == CellImage{} ? direct : direct + fractions_->translation(bond.image);
  }

 private:
  const Particles& particles_;
  std::optional<CellFractions> fractions_;
};

/// Returns the number of stated bonds of each particle. Returns none if the file states no bonds.
std::vector<std::uint32_t> stated_counts(const Particles& particles) {
  std::vector<std::uint32_t> counts(particles.bonds.empty() ? 0 : particles.count());
  for (const StatedBond& bond : particles.bonds) {
    ++counts[bond.first];
    ++counts[bond.second];
  }
  return counts;
}

/// Decides which close atoms bond. The header describes the rule.
class CloseAtoms {
 public:
  CloseAtoms(const Particles& particles, const std::vector<std::uint32_t>& stated)
      : particles_(particles), stated_(stated) {
    for (const std::string& name : particles.residue_names.names) {
      const bool polymer = is_amino_acid(name) || is_nucleotide(name);
      kinds_.push_back(is_water(name) ? Kind::water : polymer ? Kind::polymer : Kind::other);
    }
  }

  [[nodiscard]] bool may_bond(std::size_t a, std::size_t b) const {
    if (!may_be_together(a, b)) return false;
    if (same_residue(particles_, a, b)) return !is_stated(a) || !is_stated(b);
    if (kind_of(a) == Kind::water || kind_of(b) == Kind::water) return false;
    if (is_link(a, b)) return !std::ranges::binary_search(particles_.bonds, bond_between(a, b));
    const bool polymers = kind_of(a) == Kind::polymer && kind_of(b) == Kind::polymer;
    return !polymers && !is_stated(a) && !is_stated(b);
  }

 private:
  enum class Kind : std::uint8_t { other, water, polymer };

  [[nodiscard]] bool may_be_together(std::size_t a, std::size_t b) const {
    const std::vector<std::uint8_t>& elements = particles_.elements;
    if (is_noble_gas(elements[a]) && is_noble_gas(elements[b])) return false;
    const std::vector<char>& letters = particles_.alternatives;
    return letters.empty() || letters[a] == ' ' || letters[b] == ' ' || letters[a] == letters[b];
  }

  [[nodiscard]] Kind kind_of(std::size_t particle) const {
    return kinds_.empty() ? Kind::other : kinds_[particles_.residue_names.index[particle]];
  }

  [[nodiscard]] bool is_stated(std::size_t particle) const {
    return !stated_.empty() && stated_[particle] > 0;
  }

  /// Returns whether the names are those of a bond between two residues of a polymer.
  [[nodiscard]] bool is_link(std::size_t a, std::size_t b) const {
    if (particles_.atom_names.empty()) return false;
    using Link = std::pair<std::string_view, std::string_view>;
    constexpr std::array<Link, 4> links{{{"C", "N"}, {"O3'", "P"}, {"O3*", "P"}, {"SG", "SG"}}};
    const std::string_view first = particles_.atom_names.of(a);
    const std::string_view second = particles_.atom_names.of(b);
    return std::ranges::any_of(links, [&](const Link& link) {
      return link == Link(first, second) || link == Link(second, first);
    });
  }

  const Particles& particles_;
  const std::vector<std::uint32_t>& stated_;
  std::vector<Kind> kinds_;  // by number of the residue's name
};

Bonds stated_bonds(const Particles& particles, const Images& images) {
  Bonds bonds;
  bonds.reserve(particles.bonds.size());
  for (const auto& [first, second] : particles.bonds) {
    bonds.push_back({first, second, images.nearest(first, second)});
  }
  return bonds;
}

/// Removes bonds that keep water rigid in simulations.
void drop_rigid_bonds(const Particles& particles, const std::vector<std::uint32_t>& stated,
                      Bonds& bonds) {
  if (particles.elements.empty()) return;
  std::erase_if(bonds, [&](const PeriodicBond& bond) {
    return particles.elements[bond.from] == 1 && particles.elements[bond.to] == 1 &&
           stated[bond.from] > 1 && stated[bond.to] > 1;
  });
}

/// Removes bonds between two metals of which one bonds to a nonmetal.
void drop_bonds_of_metals(const Particles& particles, Bonds& bonds) {
  const auto metal = [&](std::uint32_t i) { return is_metal(particles.elements[i]); };
  std::vector<bool> compound(particles.count());
  for (const auto& [from, to, image] : bonds) {
    if (metal(from) != metal(to)) compound[from] = compound[to] = true;
  }
  std::erase_if(bonds, [&](const PeriodicBond& bond) {
    return metal(bond.from) && metal(bond.to) && (compound[bond.from] || compound[bond.to]);
  });
}

void add_bonds_of_close_atoms(const Particles& particles, const std::vector<std::uint32_t>& stated,
                              const Images& images, Bonds& bonds) {
  const CloseAtoms rule(particles, stated);
  const double least = least_distance * angstrom_of(particles);
  Bonds close = covalent_bonds(particles);
  std::erase_if(close, [&](const PeriodicBond& bond) {
    return length(images.delta(bond)) < least || !rule.may_bond(bond.from, bond.to);
  });
  drop_bonds_of_metals(particles, close);
  bonds.insert(bonds.end(), close.begin(), close.end());
}

/// Removes bonds across faces that lead to the place of another particle.
void drop_bonds_to_copies(const Particles& particles, const Images& images, Bonds& bonds) {
  const auto crosses = [](const PeriodicBond& bond) { return bond.image != CellImage{}; };
  if (std::ranges::none_of(bonds, crosses)) return;
  const NeighbourGrid present(particles.positions, least_distance * angstrom_of(particles));
  std::erase_if(bonds, [&](const PeriodicBond& bond) {
    if (!crosses(bond)) return false;
    const Vec3d delta = images.delta(bond);
    return present.near(particles.positions[bond.from] + delta) ||
           present.near(particles.positions[bond.to] - delta);
  });
}

}  // namespace

std::vector<DrawnBond> drawn_bonds(const Particles& particles, BondSource source) {
  if (source == BondSource::off) return {};
  const Images images(particles);
  Bonds bonds = stated_bonds(particles, images);
  if (source == BondSource::automatic) {
    const std::vector<std::uint32_t> stated = stated_counts(particles);
    drop_rigid_bonds(particles, stated, bonds);
    if (!particles.all_bonds) add_bonds_of_close_atoms(particles, stated, images, bonds);
  }
  drop_bonds_to_copies(particles, images, bonds);
  std::vector<DrawnBond> drawn;
  drawn.reserve(bonds.size());
  for (const PeriodicBond& bond : bonds) {
    const Vec3d delta = images.delta(bond);
    if (delta == Vec3d{}) continue;
    const bool ordered = bond.from <= bond.to;
    drawn.push_back(
        {std::min(bond.from, bond.to), std::max(bond.from, bond.to), ordered ? delta : -delta});
  }
  std::ranges::sort(drawn, {}, [](const DrawnBond& bond) {
    return std::tuple(bond.first, bond.second, bond.delta.x, bond.delta.y, bond.delta.z);
  });
  return drawn;
}

}  // namespace parray::input
