#include "cli/input/particles/element_mass.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace parray::input {
namespace {

/// By atomic number, to uranium; 0 where there is no standard weight.
constexpr std::array<double, 93> weights{
    0,      1.008,  4.0026, 6.94,   9.0122, 10.81,  12.011, 14.007, 15.999, 18.998, 20.180, 22.990,
    24.305, 26.982, 28.085, 30.974, 32.06,  35.45,  39.95,  39.098, 40.078, 44.956, 47.867, 50.942,
    51.996, 54.938, 55.845, 58.933, 58.693, 63.546, 65.38,  69.723, 72.630, 74.922, 78.971, 79.904,
    83.798, 85.468, 87.62,  88.906, 91.224, 92.906, 95.95,  0,      101.07, 102.91, 106.42, 107.87,
    112.41, 114.82, 118.71, 121.76, 127.60, 126.90, 131.29, 132.91, 137.33, 138.91, 140.12, 140.91,
    144.24, 0,      150.36, 151.96, 157.25, 158.93, 162.50, 164.93, 167.26, 168.93, 173.05, 174.97,
    178.49, 180.95, 183.84, 186.21, 190.23, 192.22, 195.08, 196.97, 200.59, 204.38, 207.2,  208.98,
    0,      0,      0,      0,      0,      0,      232.04, 231.04, 238.03};

/// Finer where united atoms are near: CH2 weighs 14.027, N 14.007.
double tolerance_at(double mass) { return mass < 20 ? 0.015 : 0.03; }

std::uint8_t element_of_mass(double mass) {
  constexpr double deuterium = 2.014;
  if (std::abs(mass - deuterium) <= tolerance_at(mass)) return 1;
  const auto* const nearest = std::ranges::min_element(weights, {}, [mass](double weight) {
    return weight > 0 ? std::abs(weight - mass) : HUGE_VAL;
  });
  const bool near = std::abs(*nearest - mass) <= tolerance_at(mass);  // false for NaN
  return near ? static_cast<std::uint8_t>(nearest - weights.begin()) : 0;
}

}  // namespace

std::vector<std::uint8_t> elements_of_masses(const std::vector<double>& masses) {
  constexpr std::uint8_t helium = 2;
  std::vector<std::uint8_t> elements(masses.size());
  std::ranges::transform(masses, elements.begin(), element_of_mass);
  const bool chemistry = std::ranges::any_of(elements, [](auto e) { return e > helium; });
  if (!chemistry) std::ranges::fill(elements, std::uint8_t{0});
  return elements;
}

ParticleNote masses_note(std::uint64_t count) {
  return {"guessed_elements", count, "elements told by their masses"};
}

void take_elements_of_masses(const std::vector<double>& masses, Particles& particles) {
  if (!particles.elements.empty() || particles.types.empty()) return;
  const std::vector<std::uint8_t> by_type = elements_of_masses(masses);
  std::vector<std::uint8_t> elements(particles.count());
  std::uint64_t guessed = 0;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    elements[i] = by_type[particles.types.index[i]];
    guessed += elements[i] == 0 ? 0 : 1;
  }
  if (guessed == 0) return;
  particles.elements = std::move(elements);
  particles.facts.notes.push_back(masses_note(guessed));
}

}  // namespace parray::input
