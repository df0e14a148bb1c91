#include "cli/input/particles/bonds.h"

#include <algorithm>
#include <cmath>

#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/beads.h"
#include "cli/input/particles/elements.h"
#include "cli/input/particles/length_unit.h"
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
    const std::array<double, 3> height{heights.x, heights.y, heights.z};
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      constexpr double slack = 1 + 1e-6;  // close atoms stay in neighbouring bins despite rounding
      const double fit = std::floor(height[i] / (longest_ * slack));
      bins_[i] = static_cast<std::int64_t>(std::clamp(fit, 1.0, static_cast<double>(most_bins)));
      const double width = height[i] / static_cast<double>(bins_[i]);
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
      const std::array<double, 3> fraction{f.x, f.y, f.z};
      for (std::size_t axis = 0; axis < bins_.size(); ++axis) {
        const auto bins = static_cast<double>(bins_[axis]);
        atom.bin[axis] =
            static_cast<std::int64_t>(std::clamp(std::floor(fraction[axis] * bins), 0.0, bins - 1));
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

}  // namespace parray::input
