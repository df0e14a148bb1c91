#include "cli/input/formats/crystal.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "cli/input/formats/gemmi_seam.h"
#include "cli/input/particles/cell.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

Vec3d placed(const ParticleCell& cell, const Vec3d& fraction) {
  return fraction.x * cell.edges[0] + fraction.y * cell.edges[1] + fraction.z * cell.edges[2];
}

/// Into [0, 1); what rounding has put just below 1 is at 0.
double wrapped(double fraction) {
  constexpr double rounding = 1e-6;
  const double part = fraction - std::floor(fraction);
  return part > 1 - rounding ? 0 : part;
}

double nearest_image(double difference) { return difference - std::round(difference); }

double periodic_distance(const ParticleCell& cell, const Vec3d& a, const Vec3d& b) {
  const Vec3d d = a - b;
  return length(placed(cell, {nearest_image(d.x), nearest_image(d.y), nearest_image(d.z)}));
}

Vec3d image_of(const SymmetryOperation& operation, const Vec3d& f) {
  const auto row = [&](std::size_t i) {
    const double* r = operation.data() + 4 * i;
    return wrapped(r[0] * f.x + r[1] * f.y + r[2] * f.z + r[3]);
  };
  return {row(0), row(1), row(2)};
}

/// The group of each assembly that is there.
std::map<std::string, std::string> chosen_groups(const std::vector<CrystalSite>& sites,
                                                 const AlternativeChoice& choice) {
  std::map<std::string, std::pair<std::string, double>> best;
  const auto wanted = [&](const std::string& group) {
    return choice.rule == AlternativeChoice::Rule::letter && group == std::string{choice.letter};
  };
  for (const CrystalSite& site : sites) {
    if (site.group.empty()) continue;
    const auto [known, fresh] =
        best.try_emplace(site.assembly, std::pair{site.group, site.occupancy});
    auto& [group, occupancy] = known->second;
    if (fresh || group == site.group) {
      occupancy = std::max(occupancy, site.occupancy);
      continue;
    }
    const bool better =
        wanted(site.group) != wanted(group) ? wanted(site.group) : site.occupancy > occupancy;
    if (better) known->second = {site.group, site.occupancy};
  }
  std::map<std::string, std::string> groups;
  for (const auto& [assembly, found] : best) groups[assembly] = found.first;
  return groups;
}

/// Sites at one place have equal keys.
std::array<long, 3> site_key(const CrystalSite& site) {
  constexpr double steps = 10000;  // along an edge
  const auto key = [](double fraction) { return std::lround(steps * wrapped(fraction)); };
  return {key(site.fraction.x), key(site.fraction.y), key(site.fraction.z)};
}

/// Leaves one group of each assembly, and one of the sites at one place: that of the highest
/// occupancy, the first of equals. Returns those that it takes out.
std::vector<CrystalSite> leave_one(std::vector<CrystalSite>& sites,
                                   const AlternativeChoice& choice) {
  const auto groups = chosen_groups(sites, choice);
  std::map<std::array<long, 3>, const CrystalSite*> best;
  const auto in_group = [&](const CrystalSite& site) {
    return site.group.empty() || groups.at(site.assembly) == site.group;
  };
  for (const CrystalSite& site : sites) {
    if (!in_group(site)) continue;
    const auto [known, fresh] = best.try_emplace(site_key(site), &site);
    if (!fresh && site.occupancy > known->second->occupancy) known->second = &site;
  }
  std::vector<CrystalSite> kept;
  std::vector<CrystalSite> out;
  for (const CrystalSite& site : sites) {
    const bool stays = in_group(site) && best.at(site_key(site)) == &site;
    (stays ? kept : out).push_back(site);
  }
  sites = std::move(kept);
  return out;
}

/// Where operations put the site, in the cell and each place once.
std::vector<Vec3d> images_of(const CrystalSite& site, const ParticleCell& cell,
                             const std::vector<SymmetryOperation>& operations) {
  constexpr double same_site = 0.4;  // angstrom
  std::vector<Vec3d> images;
  for (const SymmetryOperation& operation : operations) {
    const Vec3d image = image_of(operation, site.fraction);
    const bool known = std::ranges::any_of(images, [&](const Vec3d& other) {
      return periodic_distance(cell, image, other) < same_site;
    });
    if (!known) images.push_back(image);
  }
  return images;
}

void add_site(const CrystalSite& site, const std::vector<Vec3d>& images, const ParticleCell& cell,
              AtomColumns& atoms) {
  Atom atom;
  atom.name = site.label;
  atom.element = site.element;
  for (const Vec3d& image : images) {
    atom.position = placed(cell, image);
    atoms.add(atom);
    atoms.numbers({{site.occupancy, site.b_factor}});
  }
}

std::vector<SymmetryOperation> operations_of(const Crystal& crystal, const FilePlace& place) {
  constexpr std::size_t most = 1000;  // the largest groups of centred cells have 192
  if (crystal.operations.empty()) return operations_of_space_group(crystal.space_group);
  if (crystal.operations.size() > most) {
    place.fail("more than " + std::to_string(most) + " symmetry operations: remove some");
  }
  std::vector<SymmetryOperation> operations;
  for (const std::string& text : crystal.operations) {
    const auto operation = symmetry_operation_in(text);
    if (!operation) {
      place.fail("'" + printable(text) +
                 "' is not a symmetry operation: write it as 'x, y+1/2, -z'");
    }
    operations.push_back(*operation);
  }
  return operations;
}

}  // namespace

Particles unit_cell(Crystal crystal, const ParticleRequest& request, const FilePlace& place) {
  const std::optional<ParticleCell> cell = cell_from(crystal.lengths, crystal.angles);
  if (!cell) {
    place.fail("fractional coordinates without a cell: add _cell_length_a and the others");
  }
  std::vector<SymmetryOperation> operations = operations_of(crystal, place);
  AtomColumns atoms(place, request, {"occupancy", "b_factor"});
  if (operations.empty()) {
    atoms.note("unknown_symmetry", crystal.sites.size(),
               "sites as listed: the file names no symmetry that is known");
    operations.push_back({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  }
  std::uint64_t left_out = 0;
  if (request.alternatives.rule != AlternativeChoice::Rule::all) {
    for (const CrystalSite& site : leave_one(crystal.sites, request.alternatives)) {
      left_out += images_of(site, *cell, operations).size();
    }
  }
  std::uint64_t partial = 0;
  for (const CrystalSite& site : crystal.sites) {
    const std::vector<Vec3d> images = images_of(site, *cell, operations);
    add_site(site, images, *cell, atoms);
    if (site.occupancy < 1) partial += images.size();
  }
  atoms.note("alternatives", left_out, "atoms of disordered or shared sites left out");
  atoms.note("partial_occupancy", partial, "atoms on sites that are not fully occupied");
  Particles particles = atoms.finish();
  particles.cell = cell;
  return particles;
}

}  // namespace parray::input
