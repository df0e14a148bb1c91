#include "cli/input/particles/particle_summary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "cli/input/color/number_bounds.h"
#include "cli/input/particles/elements.h"

namespace parray::input {
namespace {

NameCounts counts_of(const NameColumn& column) {
  NameCounts counts;
  if (column.empty()) return counts;
  for (const std::string& name : column.names) counts.emplace_back(name, 0);
  for (const std::uint32_t index : column.index) ++counts[index].second;
  std::erase_if(counts, [](const auto& count) { return count.second == 0; });
  return counts;
}

void count_residues(const Particles& particles, ParticleSummary& summary) {
  if (particles.residue_names.empty() && particles.residue_numbers.empty()) return;
  NameColumn of_residues{particles.residue_names.names, {}};
  for (std::size_t i = 0; i < particles.count(); ++i) {
    if (!begins_residue(particles, i)) continue;
    ++summary.residues;
    if (!particles.residue_names.empty()) {
      of_residues.index.push_back(particles.residue_names.index[i]);
    }
  }
  summary.residue_names = counts_of(of_residues);
}

NumberRangeSeen range_of(const std::string& name, const std::vector<double>& values,
                         const std::string& unit) {
  NumberRangeSeen range{.name = name, .unit = unit};
  for (const double value : values) {
    if (std::isnan(value)) {
      ++range.missing;
      continue;
    }
    range.low = std::min(value, range.low.value_or(value));
    range.high = std::max(value, range.high.value_or(value));
  }
  return range;
}

double angle_between(const Vec3d& a, const Vec3d& b) {
  const double cosine = dot(a, b) / (length(a) * length(b));
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
}

}  // namespace

NameCounts element_counts(const std::vector<std::uint8_t>& elements) {
  std::array<std::uint64_t, last_element + 1> numbers{};
  for (const std::uint8_t element : elements) ++numbers.at(element);
  NameCounts counts;
  for (std::uint8_t i = 1; i <= last_element; ++i) {
    if (numbers.at(i) > 0) counts.emplace_back(element(i).symbol, numbers.at(i));
  }
  if (numbers[0] > 0) counts.emplace_back("unknown", numbers[0]);
  return counts;
}

bool same_residue(const Particles& particles, std::size_t i, std::size_t j) {
  const auto same = [i, j](const auto& values) { return values.empty() || values[i] == values[j]; };
  return same(particles.residue_numbers) && same(particles.insertion_codes) &&
         same(particles.residue_names.index) && same(particles.chains.index);
}

bool begins_residue(const Particles& particles, std::size_t i) {
  return i == 0 || !same_residue(particles, i, i - 1);
}

ParticleSummary summary_of(const Particles& particles) {
  ParticleSummary summary;
  summary.count = particles.count();
  if (!particles.elements.empty()) summary.elements = element_counts(particles.elements);
  summary.types = counts_of(particles.types);
  summary.chains = counts_of(particles.chains);
  count_residues(particles, summary);
  if (!particles.positions.empty()) {
    const PositionBounds bounds = bounds_of(particles.positions);
    summary.low = bounds.low;
    summary.high = bounds.high;
  }
  if (!particles.radii.empty()) {
    summary.numbers.push_back(range_of("radius", particles.radii, particles.facts.length_unit));
  }
  for (const NumberColumn& column : particles.numbers) {
    summary.numbers.push_back(range_of(column.name, column.values, column.unit));
  }
  return summary;
}

Vec3d lengths_of(const ParticleCell& cell) {
  return {length(cell.edges[0]), length(cell.edges[1]), length(cell.edges[2])};
}

Vec3d angles_of(const ParticleCell& cell) {
  const auto& [a, b, c] = cell.edges;
  return {angle_between(b, c), angle_between(a, c), angle_between(a, b)};
}

}  // namespace parray::input
