#include "cli/input/particles/particles.h"

#include <algorithm>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "cli/input/formats/format_table.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/frames.h"
#include "cli/input/particles/stated_bonds.h"
#include "common/base/error.h"
#include "common/base/printable.h"
#include "common/base/text.h"
#include "common/scene/limits.h"

namespace parray::input {
namespace {

/// Calls `work` for each column, which may be empty.
void for_each_column(Particles& particles, const auto& work) {
  work(particles.radii);
  work(particles.colors);
  work(particles.elements);
  work(particles.types.index);
  work(particles.atom_names.index);
  work(particles.residue_names.index);
  work(particles.chains.index);
  work(particles.residue_numbers);
  work(particles.insertion_codes);
  work(particles.alternatives);
  for (NumberColumn& column : particles.numbers) work(column.values);
  work(particles.indices);
  work(particles.positions);
}

void keep_in(auto& column, const ParticleMask& mask) {
  if (column.empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != 0) column[kept++] = column[i];
  }
  column.resize(kept);
}

const ParticleFormat& format_of(PackedFile& file) {
  const ParticleFormat* const format = particle_format_of(file);
  if (format != nullptr) return *format;
  FilePlace{file.name()}.fail("this is a scene file: name a particle file instead");
}

Particles read(PackedFile& file, const ParticleFormat& format, const ParticleRequest& request) {
  const std::uint64_t frame = request.frame_number();
  if (frame > 0 && !format.frames) {
    FilePlace{file.name()}.fail("the file has no frame " + std::to_string(frame) +
                                ": it has one frame, number 0");
  }
  const bool goes_on =
      request.continues() && format.frames && request.cursor->leads_to(file, request);
  if (!goes_on) file.rewind();
  Particles particles = format.read(file, request);
  particles.facts.format = format.name;
  if (format.in_angstrom) particles.facts.length_unit = "angstrom";
  particles.facts.packing = file.packing();
  return particles;
}

using Order = std::vector<std::size_t>;  ///< for each particle, its place in the topology

constexpr std::string_view id_name = "id";

Order same_order(std::size_t count) {
  Order order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  return order;
}

Order by_number(const std::vector<double>& numbers) {
  Order order = same_order(numbers.size());
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return numbers[i]; });
  return order;
}

/// Finds the place of each of `wanted` in `numbers`.
Order same_numbers(const std::vector<double>& wanted, const std::vector<double>& numbers,
                   const std::filesystem::path& topology) {
  std::unordered_map<double, std::size_t> places;
  for (std::size_t i = 0; i < numbers.size(); ++i) places.emplace(numbers[i], i);
  Order order;
  for (const double number : wanted) {
    const auto found = places.find(number);
    if (found == places.end()) {
      FilePlace{topology.string()}.fail("no atom has the id " + number_text(number) +
                                        ": check that the topology belongs to the same system");
    }
    order.push_back(found->second);
  }
  return order;
}

/// Matches the particles of the unordered `file` with a topology whose atoms have no numbers.
/// Returns the atom of each particle: the particle with the smallest of the `numbers` is atom 0.
/// Adds a note to `facts` if the particles are not in this order.
Order by_own_number(const std::vector<double>& numbers, const std::filesystem::path& file,
                    ParticleFacts& facts) {
  Order order = same_order(numbers.size());
  if (std::ranges::is_sorted(numbers)) return order;
  const Order sorted = by_number(numbers);
  for (std::size_t place = 0; place < sorted.size(); ++place) {
    const double number = numbers[sorted[place]];
    if (place > 0 && numbers[sorted[place - 1]] == number) {
      FilePlace{file.string()}.fail(
          "the atoms are unsorted, and several have the id " + number_text(number) +
          ", so the names of the topology cannot be matched: sort the file by atoms, such as with "
          "dump_modify sort id");
    }
    order[sorted[place]] = place;
  }
  facts.note("unsorted_atoms", numbers.size(),
             "particles that are not sorted by id: the first atom of the topology belongs to "
             "the smallest id, and so on");
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
    if (to.numbers_named(column.name) != nullptr || !request.wants(column.name)) continue;
    to.numbers.push_back({column.name, {}, column.unit});
    take(column.values, order, to.numbers.back().values);
  }
}

/// Copies to particles what the file `topology` contains for the same atoms: elements, names,
/// residues, radii and colours, bonds, and the numbers that the request wants. Other columns stay
/// unchanged. Some topologies number their atoms (column "id"; LAMMPS writes atoms in any order).
/// Then particle i is the atom with the i-th smallest number or, if the particles have a column
/// "id" too, the atom with the same number. If only the particles have numbers, and `format` is
/// unordered, the first atom belongs to the particle with the smallest number, and so on.
///
/// Throws InputError if the topology and the particles, from `file`, differ in their number of
/// atoms or in their ids, or if the particles are unsorted and some have the same id.
void take_topology(const std::filesystem::path& topology, const std::filesystem::path& file,
                   const ParticleFormat& format, const ParticleRequest& request,
                   Particles& particles) {
  ParticleRequest names{.numbers = request.numbers, .threads = request.threads};
  names.alternatives.rule = AlternativeChoice::Rule::all;
  names.numbers.emplace(id_name);
  Particles from = read_names(topology, names);
  if (from.count() != particles.count()) {
    FilePlace{topology.string()}.fail(
        std::to_string(from.count()) + " atoms, but " + printable(file.string(), 4096) + " has " +
        std::to_string(particles.count()) + ": name the topology of the same atoms");
  }
  const NumberColumn* const own_ids = particles.numbers_named(id_name);
  const NumberColumn* const ids = from.numbers_named(id_name);
  Order order = same_order(from.count());
  if (ids != nullptr) {
    order = own_ids == nullptr ? by_number(ids->values)
                               : same_numbers(own_ids->values, ids->values, topology);
  } else if (own_ids != nullptr && format.unordered) {
    order = by_own_number(own_ids->values, file, particles.facts);
  }
  take(from.elements, order, particles.elements);
  take(from.radii, order, particles.radii);
  take(from.colors, order, particles.colors);
  take(from.residue_numbers, order, particles.residue_numbers);
  if (!from.residue_numbers.empty()) particles.insertion_codes.clear();
  take(from.insertion_codes, order, particles.insertion_codes);
  take(std::move(from.types), order, particles.types);
  take(std::move(from.atom_names), order, particles.atom_names);
  take(std::move(from.residue_names), order, particles.residue_names);
  take(std::move(from.chains), order, particles.chains);
  take_numbers(from, order, request, particles);
  if (!from.bonds.empty()) {
    particles.bonds = renumbered(from.bonds, order);
    particles.all_bonds = from.all_bonds;
  }
  // Removes the note on the unit of the topology's positions, because these are not used.
  std::erase_if(from.facts.notes,
                [](const ParticleNote& note) { return note.key == "length_unit"; });
  std::ranges::move(from.facts.notes, std::back_inserter(particles.facts.notes));
}

}  // namespace

void ParticleFacts::note(std::string key, std::uint64_t count, std::string text) {
  if (count > 0) notes.push_back({std::move(key), count, std::move(text)});
}

const NumberColumn* Particles::numbers_named(std::string_view name) const {
  const auto found = std::ranges::find(numbers, name, &NumberColumn::name);
  return found == numbers.end() ? nullptr : &*found;
}

void keep(Particles& particles, const ParticleMask& mask) {
  keep_bonds(particles.bonds, mask);
  if (particles.indices.empty()) {
    particles.indices.resize(particles.count());
    std::iota(particles.indices.begin(), particles.indices.end(), std::uint32_t{0});
  }
  for_each_column(particles, [&](auto& column) { keep_in(column, mask); });
}

void repeat(Particles& particles, std::uint64_t times) {
  for_each_column(particles, [&](auto& column) {
    const std::size_t count = column.size();
    column.resize(count * static_cast<std::size_t>(times));
    for (std::size_t i = count; i < column.size(); ++i) column[i] = column[i - count];
  });
}

void append_copies(Particles& particles, const std::vector<std::size_t>& sources) {
  append_bonds_of_copies(particles.bonds, particles.count(), sources);
  for_each_column(particles, [&](auto& column) {
    if (column.empty()) return;
    column.reserve(column.size() + sources.size());
    for (const std::size_t source : sources) column.push_back(column[source]);
  });
}

AlternativeChoice alternatives_from(std::string_view text) {
  using Rule = AlternativeChoice::Rule;
  if (text == "best") return AlternativeChoice{};
  if (text == "all") return AlternativeChoice{Rule::all, ' '};
  if (text.size() == 1 && text[0] > ' ' && text[0] <= '~') {
    return AlternativeChoice{Rule::letter, text[0]};
  }
  throw InputError("unknown alternatives '" + printable(text) + "': write best, all or one letter");
}

std::string text_of(const AlternativeChoice& choice) {
  if (choice.rule == AlternativeChoice::Rule::best) return {};
  return choice.rule == AlternativeChoice::Rule::all ? "all" : std::string{choice.letter};
}

std::optional<FrameChoice> frame_from(std::string_view text) {
  if (text == last_frame_word) return FrameChoice{0, true};
  const std::optional<std::uint64_t> number = natural_in(text);
  if (number && *number <= limits::max_frame) return FrameChoice{*number, false};
  throw InputError("'" + printable(text) + "' is not a frame: write a number from 0 to " +
                   std::to_string(limits::max_frame) + ", or last");
}

std::string text_of(const std::optional<FrameChoice>& choice) {
  if (!choice) return {};
  return choice->last ? std::string(last_frame_word) : std::to_string(choice->number);
}

Particles read_particles(const std::filesystem::path& path, const ParticleRequest& request) {
  PackedFile file(path);
  return read_particles(file, request);
}

Particles read_particles(PackedFile& file, const ParticleRequest& request) {
  const ParticleFormat& format = format_of(file);
  if (format.holds == ParticleFormat::Holds::names) {
    FilePlace{file.name()}.fail(
        "a " + std::string(format.name) +
        " file has no positions: name a trajectory, and give this file as its topology");
  }
  if (request.topology.empty()) {
    Particles particles = read(file, format, request);
    if (format.holds == ParticleFormat::Holds::positions) {
      particles.facts.note(
          "nameless", particles.count(),
          in_number(
              particles.count(),
              "particle that has only positions in this file: add a topology to give it a name",
              "particles that have only positions in this file: add a topology to give them "
              "names"));
    }
    return particles;
  }
  ParticleRequest with_ids = request;
  with_ids.numbers.emplace("id");
  Particles particles = read(file, format, with_ids);
  take_topology(request.topology, file.name(), format, request, particles);
  std::erase_if(particles.numbers,
                [&](const NumberColumn& column) { return !request.wants(column.name); });
  return particles;
}

Particles read_names(const std::filesystem::path& path, const ParticleRequest& request) {
  PackedFile file(path);
  return read(file, format_of(file), request);
}

}  // namespace parray::input
