#include "cli/input/particles/cell_operations.h"

#include <algorithm>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/molecules.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"
#include "common/math/largest_component.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

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
                       in_number(copies, "copy of an atom", "copies of atoms") +
                           " on faces of the cell drawn on the opposite faces");
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
