#include "cli/input/particles/stated_bonds.h"

#include <algorithm>
#include <limits>
#include <unordered_map>

namespace parray::input {
namespace {

using Number = std::uint32_t;
constexpr Number no_particle = std::numeric_limits<Number>::max();

/// Replaces the numbers of particles. Removes the bonds of particles that have no new number.
void renumber(std::vector<StatedBond>& bonds, const std::vector<Number>& numbers) {
  std::size_t kept = 0;
  for (const StatedBond& bond : bonds) {
    const Number first = numbers[bond.first];
    const Number second = numbers[bond.second];
    if (first == no_particle || second == no_particle) continue;
    bonds[kept++] = bond_between(first, second);
  }
  bonds.resize(kept);
  put_in_order(bonds);
}

}  // namespace

StatedBond bond_between(std::uint64_t one, std::uint64_t other) {
  return {static_cast<Number>(std::min(one, other)), static_cast<Number>(std::max(one, other))};
}

void put_in_order(std::vector<StatedBond>& bonds) {
  std::ranges::sort(bonds);
  bonds.erase(std::unique(bonds.begin(), bonds.end()), bonds.end());
}

void keep_bonds(std::vector<StatedBond>& bonds, const ParticleMask& mask) {
  if (bonds.empty()) return;
  std::vector<Number> numbers(mask.size(), no_particle);
  Number kept = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != 0) numbers[i] = kept++;
  }
  renumber(bonds, numbers);
}

void append_bonds_of_copies(std::vector<StatedBond>& bonds, std::size_t count,
                            const std::vector<std::size_t>& sources) {
  if (bonds.empty()) return;
  std::unordered_map<std::size_t, std::vector<std::size_t>> copies;
  for (std::size_t i = 0; i < sources.size(); ++i) copies[sources[i]].push_back(count + i);
  const auto with_copies = [&](std::size_t particle) {
    std::vector<std::size_t> all{particle};
    const auto found = copies.find(particle);
    if (found != copies.end()) all.insert(all.end(), found->second.begin(), found->second.end());
    return all;
  };
  const std::size_t stated = bonds.size();
  for (std::size_t i = 0; i < stated; ++i) {
    const StatedBond bond = bonds[i];
    for (const std::size_t first : with_copies(bond.first)) {
      for (const std::size_t second : with_copies(bond.second)) {
        bonds.push_back(bond_between(first, second));
      }
    }
  }
  put_in_order(bonds);
}

std::vector<StatedBond> renumbered(const std::vector<StatedBond>& bonds,
                                   const std::vector<std::size_t>& order) {
  std::size_t most = 0;
  for (const std::size_t before : order) most = std::max(most, before);
  for (const StatedBond& bond : bonds) most = std::max<std::size_t>(most, bond.second);
  std::vector<Number> numbers(most + 1, no_particle);
  for (std::size_t i = 0; i < order.size(); ++i) numbers[order[i]] = static_cast<Number>(i);
  std::vector<StatedBond> bonds_now = bonds;
  renumber(bonds_now, numbers);
  return bonds_now;
}

}  // namespace parray::input
