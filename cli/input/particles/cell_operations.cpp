#include "cli/input/particles/cell_operations.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <unordered_map>

#include "cli/input/particles/bonds.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particle_summary.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "common/math/largest_component.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

constexpr std::uint32_t no_molecule = std::numeric_limits<std::uint32_t>::max();

/// Follows the bonds from atom to atom and finds the image of each atom beside the others of its
/// molecule.
class BondWalk {
 public:
  BondWalk(std::size_t atoms, const std::vector<PeriodicBond>& bonds)
      : starts_(atoms + 1), images_(atoms), molecules_{std::vector(atoms, no_molecule), 0} {
    for (const PeriodicBond& bond : bonds) {
      ++starts_[bond.from + 1];
      ++starts_[bond.to + 1];
    }
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    ways_.resize(2 * bonds.size());
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for (const PeriodicBond& bond : bonds) {
      const CellImage& image = bond.image;
      ways_[next[bond.from]++] = {bond.to, image};
      ways_[next[bond.to]++] = {bond.from, {-image[0], -image[1], -image[2]}};
    }
    for (std::uint32_t atom = 0; atom < atoms; ++atom) {
      if (molecules_.of[atom] == no_molecule) walk(atom);
    }
  }

  [[nodiscard]] const CellImage& image(std::size_t atom) const { return images_[atom]; }
  Molecules take() { return std::move(molecules_); }

 private:
  struct Way {
    std::uint32_t to;
    CellImage image;
  };

  /// Follows all bonds from `start`. Each atom of an endless molecule becomes a molecule.
  void walk(std::uint32_t start) {
    const std::uint32_t molecule = count_++;
    std::vector<std::uint32_t> atoms{start};
    molecules_.of[start] = molecule;
    bool endless = false;
    for (std::size_t i = 0; i < atoms.size(); ++i) {
      const std::uint32_t atom = atoms[i];
      for (const Way& way :
           std::span(ways_).subspan(starts_[atom], starts_[atom + 1] - starts_[atom])) {
        CellImage image = images_[atom];
        for (std::size_t axis = 0; axis < image.size(); ++axis) image[axis] += way.image[axis];
        if (molecules_.of[way.to] == molecule) {
          endless = endless || image != images_[way.to];
          continue;
        }
        molecules_.of[way.to] = molecule;
        images_[way.to] = image;
        atoms.push_back(way.to);
      }
    }
    if (!endless) return;
    ++molecules_.endless;
    for (const std::uint32_t atom : atoms) {
      images_[atom] = {};
      if (atom != start) molecules_.of[atom] = count_++;
    }
  }

  std::uint32_t count_ = 0;          // of molecules
  std::vector<std::size_t> starts_;  // of an atom's ways
  std::vector<Way> ways_;
  std::vector<CellImage> images_;
  Molecules molecules_;
};

/// Numbers molecules by equal values, in the order of their first use.
std::vector<std::uint32_t> molecules_of(const std::vector<double>& numbers) {
  std::unordered_map<double, std::uint32_t> known;
  std::vector<std::uint32_t> molecules;
  for (const double number : numbers) {
    const auto fresh = static_cast<std::uint32_t>(known.size());
    molecules.push_back(known.try_emplace(std::isnan(number) ? -1 : number, fresh).first->second);
  }
  return molecules;
}

/// Returns the numbers of the residues, which are runs of particles. Large files use the same
/// residue number again.
std::vector<std::uint32_t> residues_of(const Particles& particles) {
  std::vector<std::uint32_t> residues(particles.count());
  for (std::size_t i = 1; i < residues.size(); ++i) {
    residues[i] = residues[i - 1] + (begins_residue(particles, i) ? 1 : 0);
  }
  return residues;
}

/// Returns the molecules that the columns of the file name. Returns nothing without such columns.
std::vector<std::uint32_t> named_molecules(const Particles& particles) {
  for (const std::string_view name : molecule_numbers) {
    if (const auto* numbers = particles.numbers_named(name)) return molecules_of(numbers->values);
  }
  return particles.residue_numbers.empty() ? std::vector<std::uint32_t>{} : residues_of(particles);
}

/// Brings each particle to the image nearest to the particle before it in the same molecule.
void follow_order(const std::vector<std::uint32_t>& molecules, Particles& particles) {
  std::vector<std::size_t> order(particles.count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (const NumberColumn* const ids = particles.numbers_named("id")) {
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return ids->values[i]; });
  }
  const CellFractions fractions(*particles.cell);
  constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> last(std::ranges::max(molecules) + std::size_t{1}, none);
  for (const std::size_t i : order) {
    std::size_t& before = last[molecules[i]];
    Vec3d& position = particles.positions[i];
    if (before != none) {
      position = position +
                 fractions.translation(fractions.nearest(particles.positions[before], position));
    }
    before = i;
  }
}

/// Returns the key of the first operation that needs a cell. Returns nullptr if there is none.
const char* needs_cell(const CellOperations& operations) {
  if (operations.replicate.any()) return "replicate";
  if (operations.whole) return "whole";
  if (!operations.center.empty()) return "center";
  if (operations.wrap) return "wrap";
  return operations.crystal.value_or(false) ? "crystal" : nullptr;
}

void center_selection(const std::string& text, Particles& particles, int threads) {
  center_on(particles,
            Selection(text).some(particles, threads, "no particle is selected: ", "select some"));
}

void add_boundary(const Replicas& replicas, Particles& particles) {
  constexpr double share = 1e-3;  // of an edge of the file's cell
  const auto& [a, b, c] = replicas.counts;
  const std::uint64_t copies = add_boundary_copies(particles, {share / a, share / b, share / c});
  particles.facts.note("boundary_copies", copies,
                       in_number(copies, "copy of an atom", "copies of atoms")
                           .append(" on faces of the cell drawn on the opposite faces"));
}

void check_coordinates(const char* key, const std::vector<Vec3d>& positions) {
  const auto inside = [](const Vec3d& p) { return largest_component(p) <= limits::max_length; };
  if (std::ranges::all_of(positions, inside)) return;
  throw SourceError(
      key, "a coordinate would be beyond 1e15: use fewer copies or a larger unit of length");
}

Molecules joined_molecules(Particles& particles) {
  Molecules molecules = blaming("whole", [&] { return make_whole(particles); });
  particles.facts.note(
      "endless_molecules", molecules.endless,
      in_number(molecules.endless, "molecule bonds to itself", "molecules bond to themselves") +
          " across the cell and cannot be made whole");
  return molecules;
}

}  // namespace

Molecules make_whole(Particles& particles) {
  const bool any_element =
      std::ranges::any_of(particles.elements, [](std::uint8_t element) { return element != 0; });
  if (any_element) {
    BondWalk walk(particles.count(), covalent_bonds(particles));
    const CellFractions fractions(*particles.cell);
    for (std::size_t i = 0; i < particles.count(); ++i) {
      Vec3d& position = particles.positions[i];
      position = position + fractions.translation(walk.image(i));
    }
    return walk.take();
  }
  Molecules molecules{named_molecules(particles), 0};
  if (molecules.of.empty()) {
    throw InputError(
        "the file has no elements, no molecule numbers and no residue numbers: add a topology, or "
        "use \"wrap\" instead");
  }
  follow_order(molecules.of, particles);
  return molecules;
}

bool is_crystal(const Particles& particles) {
  return particles.cell && std::ranges::count(particles.cell->periodic, true) > 0 &&
         particles.count() <= most_crystal_atoms && particles.residue_names.empty() &&
         particles.residue_numbers.empty() && particles.chains.empty();
}

void apply(const CellOperations& operations, Particles& particles, int threads) {
  const char* const key = needs_cell(operations);
  if (key == nullptr) return;
  if (!particles.cell) throw SourceError(key, "the file has no box and no cell: leave it out");
  Molecules molecules;
  if (operations.whole) molecules = joined_molecules(particles);
  if (!operations.center.empty()) {
    blaming("center", [&] { center_selection(operations.center, particles, threads); });
  }
  if (operations.wrap || !operations.center.empty()) wrap(particles, molecules.of);
  if (operations.replicate.any()) {
    blaming("replicate", [&] { replicate(particles, operations.replicate); });
  }
  if (operations.crystal.value_or(false)) add_boundary(operations.replicate, particles);
  check_coordinates(key, particles.positions);
}

}  // namespace parray::input
