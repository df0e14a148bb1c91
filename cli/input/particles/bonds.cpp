#include "cli/input/particles/bonds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/beads.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/length_unit.h"
#include "cli/input/particles/particle_summary.h"
#include "cli/input/particles/residues.h"
#include "cli/input/particles/stated_bonds.h"
#include "cli/input/select/neighbour_grid.h"
#include "common/base/error.h"

namespace parray::input {
namespace {

constexpr double bond_slack = 0.4;  // angstrom

bool may_bond(std::uint8_t element) { return element != 0 && !is_ionic(element); }

[[noreturn]] void fail_unit(const Particles& particles) {
  const std::string unit = angstrom_of(particles) == 1 ? "angstrom" : particles.facts.length_unit;
  throw InputError("atoms are too close for bonds if lengths are in " + unit +
                   ": correct the unit of positions and cell");
}

/// Fails if the nearest neighbours of most atoms are closer than atoms can be.
void check_unit(const Particles& particles) {
  constexpr double least = 0.5;  // angstrom; hydrogen has 0.74
  std::vector<Vec3d> positions;
  for (std::size_t i = 0; i < particles.elements.size(); ++i) {
    if (may_bond(particles.elements[i])) positions.push_back(particles.positions[i]);
  }
  const double typical = typical_distance(positions);
  if (typical > 0 && typical < least * angstrom_of(particles)) fail_unit(particles);
}

/// Returns the cell of the particles. Without one, returns a box around them, at least `least`
/// wide, that is not periodic.
ParticleCell cell_of(const Particles& particles, double least) {
  if (particles.cell) return *particles.cell;
  const auto [low, high] = bounds_of(particles.positions);
  const Vec3d extent = high - low;
  return {low,
          {Vec3d{std::max(extent.x, least), 0, 0}, Vec3d{0, std::max(extent.y, least), 0},
           Vec3d{0, 0, std::max(extent.z, least)}},
          {false, false, false}};
}

double longest_bond(const Particles& particles) {
  double largest = 0;
  for (const std::uint8_t element : particles.elements) {
    if (may_bond(element)) largest = std::max(largest, covalent_radius(element));
  }
  return (2 * largest + bond_slack) * angstrom_of(particles);
}

/// Finds bonds with the help of bins, whose edges are parallel to those of the cell.
class BondFinder {
 public:
  explicit BondFinder(const Particles& particles)
      : particles_(particles),
        angstrom_(angstrom_of(particles)),
        longest_(longest_bond(particles)),
        cell_(cell_of(particles, longest_)),
        fractions_(cell_) {
    choose_bins();
    fill_bins();
  }

  std::vector<PeriodicBond> find() {
    for (std::size_t first = 0; first < atoms_.size(); first = end_of_bin(first)) {
      if (end_of_bin(first) - first > most_in_bin) fail_unit(particles_);
      for (Bin step{0, 0, 0}; step[2] <= reach_[2]; advance(step)) visit(first, step);
    }
    return std::move(bonds_);
  }

 private:
  using Bin = std::array<std::int64_t, 3>;
  struct BinnedAtom {
    std::uint64_t key;
    std::uint32_t index;
    Bin bin;
    CellImage image;  // of the cell that contains the atom
    Vec3d position;   // inside the cell, along periodic edges
  };
  static constexpr std::int64_t most_bins = std::int64_t{1} << 20;  // along an edge
  static constexpr std::size_t most_in_bin = 2000;                  // 20 in matter

  void choose_bins() {
    const Vec3d heights = fractions_.heights();
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      constexpr double slack = 1 + 1e-6;  // close atoms stay in neighbouring bins despite rounding
      const double height = component(heights, i);
      const double fit = std::floor(height / (longest_ * slack));
      bins_[i] = static_cast<std::int64_t>(std::clamp(fit, 1.0, static_cast<double>(most_bins)));
      const double width = height / static_cast<double>(bins_[i]);
      const double reach = std::ceil(longest_ / width);
      constexpr double most_reach = 8;
      if (!(reach <= most_reach)) fail_unit(particles_);
      reach_[i] = static_cast<std::int64_t>(reach);
    }
  }

  void fill_bins() {
    for (std::size_t i = 0; i < particles_.count(); ++i) {
      if (!may_bond(particles_.elements[i])) continue;
      BinnedAtom atom{};
      atom.index = static_cast<std::uint32_t>(i);
      atom.image = fractions_.image_of(fractions_.of(particles_.positions[i]));
      atom.position = particles_.positions[i] - fractions_.translation(atom.image);
      const Vec3d f = fractions_.of(atom.position);
      for (std::size_t axis = 0; axis < bins_.size(); ++axis) {
        const auto bins = static_cast<double>(bins_[axis]);
        atom.bin[axis] = static_cast<std::int64_t>(
            std::clamp(std::floor(component(f, axis) * bins), 0.0, bins - 1));
      }
      atom.key = key_of(atom.bin);
      atoms_.push_back(atom);
    }
    std::ranges::sort(atoms_, [](const BinnedAtom& a, const BinnedAtom& b) {
      return a.key != b.key ? a.key < b.key : a.index < b.index;
    });
  }

  static std::uint64_t key_of(const Bin& bin) {
    constexpr int bits = 21;
    return (static_cast<std::uint64_t>(bin[2]) << (2 * bits)) |
           (static_cast<std::uint64_t>(bin[1]) << bits) | static_cast<std::uint64_t>(bin[0]);
  }
  [[nodiscard]] std::size_t end_of_bin(std::size_t first) const {
    std::size_t end = first;
    while (end < atoms_.size() && atoms_[end].key == atoms_[first].key) ++end;
    return end;
  }

  /// Goes to the next step between bins. Of two opposite steps, only one comes up.
  void advance(Bin& step) const {
    if (++step[0] <= reach_[0]) return;
    step[0] = -reach_[0];
    if (++step[1] <= reach_[1]) return;
    step[1] = -reach_[1];
    ++step[2];
  }

  /// Finds the bonds between a bin, which begins at atom `first`, and the bin at `step`.
  void visit(std::size_t first, const Bin& step) {
    Bin bin = atoms_[first].bin;
    CellImage image{};  // of the cell that contains the other bin
    for (std::size_t i = 0; i < bin.size(); ++i) {
      bin[i] += step[i];
      image[i] = bin[i] >= 0 ? bin[i] / bins_[i] : -((bins_[i] - 1 - bin[i]) / bins_[i]);
      if (image[i] != 0 && !cell_.periodic[i]) return;
      bin[i] -= image[i] * bins_[i];
    }
    const auto other = static_cast<std::size_t>(
        std::ranges::lower_bound(atoms_, key_of(bin), {}, &BinnedAtom::key) - atoms_.begin());
    if (other == atoms_.size() || atoms_[other].key != key_of(bin)) return;
    const Vec3d shift = fractions_.translation(image);
    const std::size_t end = end_of_bin(first);
    const std::size_t other_end = end_of_bin(other);
    const bool same = step == Bin{};
    for (std::size_t a = first; a < end; ++a) {
      for (std::size_t b = same ? a + 1 : other; b < other_end; ++b) {
        if (are_bonded(atoms_[a], atoms_[b], shift)) add(atoms_[a], atoms_[b], image);
      }
    }
  }

  [[nodiscard]] bool are_bonded(const BinnedAtom& a, const BinnedAtom& b,
                                const Vec3d& shift) const {
    const Vec3d d = b.position + shift - a.position;
    const double square = dot(d, d);
    if (square > longest_ * longest_) return false;
    const std::uint8_t first = particles_.elements[a.index];
    const std::uint8_t second = particles_.elements[b.index];
    if (first == 1 && second == 1) return false;
    const double most = angstrom_ * (covalent_radius(first) + covalent_radius(second) + bond_slack);
    return square <= most * most;
  }

  void add(const BinnedAtom& a, const BinnedAtom& b, CellImage image) {
    for (std::size_t i = 0; i < image.size(); ++i) image[i] += a.image[i] - b.image[i];
    bonds_.push_back({a.index, b.index, image});
  }

  const Particles& particles_;
  double angstrom_;  // in the unit of the particles
  double longest_;
  ParticleCell cell_;
  CellFractions fractions_;
  Bin bins_{};
  Bin reach_{};
  std::vector<BinnedAtom> atoms_;  // that may bond; sorted by key
  std::vector<PeriodicBond> bonds_;
};

constexpr double least_distance = 0.5;  // angstrom, of two atoms

using Bonds = std::vector<PeriodicBond>;

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

double angstrom_of(const Particles& particles) {
  constexpr double metres = 1e-10;
  const LengthUnit* const unit = length_unit(particles.facts.length_unit);
  return unit != nullptr && unit->metres > 0 ? metres / unit->metres : 1;
}

std::vector<PeriodicBond> covalent_bonds(const Particles& particles) {
  if (std::ranges::none_of(particles.elements, may_bond)) return {};
  check_unit(particles);
  return BondFinder(particles).find();
}

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
