#include "cli/input/particles/topology.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <unordered_map>
#include <utility>

#include "cli/input/particles/file_place.h"
#include "common/base/printable.h"

namespace parray::input {
namespace {

using Order = std::vector<std::size_t>;  ///< for each particle, its place in the topology

constexpr std::string_view id_name = "id";

const std::vector<double>* ids_of(const Particles& particles) {
  const auto found = std::ranges::find(particles.numbers, id_name, &NumberColumn::name);
  return found == particles.numbers.end() ? nullptr : &found->values;
}

Order by_number(const std::vector<double>& numbers) {
  Order order(numbers.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return numbers[i]; });
  return order;
}

/// Finds each of `wanted` among `numbers`.
Order same_numbers(const std::vector<double>& wanted, const std::vector<double>& numbers,
                   const std::filesystem::path& topology) {
  std::unordered_map<double, std::size_t> places;
  for (std::size_t i = 0; i < numbers.size(); ++i) places.emplace(numbers[i], i);
  Order order;
  for (const double number : wanted) {
    const auto found = places.find(number);
    if (found == places.end()) {
      FilePlace{topology.string()}.fail("no atom has the id " + number_text(number) +
                                        ": is it of the same system?");
    }
    order.push_back(found->second);
  }
  return order;
}

template <typename Value>
void take(const std::vector<Value>& from, const Order& order, std::vector<Value>& to) {
  if (from.empty()) return;
  to.resize(order.size());
  std::ranges::transform(order, to.begin(), [&](std::size_t i) { return from[i]; });
}

void take(NameColumn from, const Order& order, NameColumn& to) {
  if (from.empty()) return;
  take(from.index, order, to.index);
  to.names = std::move(from.names);
}

void take_numbers(const Particles& from, const Order& order, const ParticleRequest& request,
                  Particles& to) {
  for (const NumberColumn& column : from.numbers) {
    const bool known =
        std::ranges::find(to.numbers, column.name, &NumberColumn::name) != to.numbers.end();
    if (known || !request.wants(column.name)) continue;
    to.numbers.push_back({column.name, {}});
    take(column.values, order, to.numbers.back().values);
  }
}

}  // namespace

void take_topology(const std::filesystem::path& topology, const std::filesystem::path& file,
                   const ParticleRequest& request, Particles& particles) {
  ParticleRequest names{.numbers = request.numbers, .threads = request.threads};
  names.alternatives.rule = AlternativeChoice::Rule::all;
  names.numbers.emplace(id_name);
  Particles from = read_names(topology, names);
  if (from.count() != particles.count()) {
    FilePlace{topology.string()}.fail(
        std::to_string(from.count()) + " atoms, but " + printable(file.string(), 4096) + " has " +
        std::to_string(particles.count()) + ": name the topology of the same atoms");
  }
  const std::vector<double>* const own_ids = ids_of(particles);
  const std::vector<double>* const ids = ids_of(from);
  Order order(from.count());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (ids != nullptr) {
    order = own_ids == nullptr ? by_number(*ids) : same_numbers(*own_ids, *ids, topology);
  }
  take(from.elements, order, particles.elements);
  take(from.radii, order, particles.radii);
  take(from.colors, order, particles.colors);
  take(from.residue_numbers, order, particles.residue_numbers);
  take(std::move(from.types), order, particles.types);
  take(std::move(from.atom_names), order, particles.atom_names);
  take(std::move(from.residue_names), order, particles.residue_names);
  take(std::move(from.chains), order, particles.chains);
  take_numbers(from, order, request, particles);
  // Its positions are not used.
  std::erase_if(from.facts.notes,
                [](const ParticleNote& note) { return note.key == "length_unit"; });
  std::ranges::move(from.facts.notes, std::back_inserter(particles.facts.notes));
}

}  // namespace parray::input
