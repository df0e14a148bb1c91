#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "cli/input/particles/selected_particles.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/selection.h"
#include "common/base/error.h"

namespace parray::input {
namespace {

constexpr auto no_owner = std::numeric_limits<std::uint16_t>::max();

struct Owners {
  std::vector<std::uint16_t> number;  ///< one per particle; no_owner: none
  std::uint64_t shared = 0;           ///< number of particles in several selections
};

/// Returns the particles in a selection. Throws SourceError if there are none.
ParticleMask selected(const std::string& text, const Particles& particles, int threads) {
  return blaming("select", [&] {
    return Selection(text).some(
        particles, threads,
        "the selection has none of " + std::to_string(particles.count()) + " particles: ",
        "select more");
  });
}

Owners owners_of(const Particles& particles, const std::vector<Representation>& shows,
                 int threads) {
  Owners owners;
  owners.number.assign(particles.count(), no_owner);
  ParticleMask shared(particles.count(), 0);
  for (std::size_t show = 0; show < shows.size(); ++show) {
    in_representation(show, [&] {
      const ParticleMask mask = selected(shows[show].select, particles, threads);
      for (std::size_t i = 0; i < mask.size(); ++i) {
        if (mask[i] == 0) continue;
        if (owners.number[i] != no_owner) shared[i] = 1;
        owners.number[i] = static_cast<std::uint16_t>(show);
      }
    });
  }
  owners.shared = static_cast<std::uint64_t>(std::ranges::count(shared, 1));
  return owners;
}

std::vector<std::uint32_t> places_in(const ParticleMask& mask) {
  std::vector<std::uint32_t> places;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] != 0) places.push_back(static_cast<std::uint32_t>(i));
  }
  return places;
}

void add_notes(const Owners& owners, ParticleFacts& facts) {
  facts.note(
      "shown_twice", owners.shared,
      particles_word(owners.shared) + " in several representations, drawn as the last of them");
  const auto left = static_cast<std::uint64_t>(std::ranges::count(owners.number, no_owner));
  facts.note("not_shown", left, particles_word(left) + " in no representation, not shown");
}

}  // namespace

std::vector<ParticlePart> split(Particles& particles, const ParticleSource& source, int threads) {
  std::vector<ParticlePart> parts;
  ParticleFacts facts = std::move(particles.facts);
  const auto add = [&](Particles part, ParticleLook look, std::optional<std::size_t> number,
                       std::vector<std::uint32_t> numbers) {
    part.facts = {.format = {}, .length_unit = facts.length_unit};
    parts.push_back({std::move(part), std::move(look), number, std::move(numbers), {}, {}});
  };
  const std::optional<ParticleCell> cell = particles.cell;
  if (source.shows.empty()) {
    add(std::move(particles), source.look, {}, {});
  } else {
    const Owners owners = owners_of(particles, source.shows, threads);
    add_notes(owners, facts);
    for (std::size_t show = 0; show < source.shows.size(); ++show) {
      ParticleMask mask(particles.count());
      std::ranges::transform(owners.number, mask.begin(), [show](std::uint16_t owner) {
        return static_cast<std::uint8_t>(owner == show ? 1 : 0);
      });
      if (std::ranges::find(mask, 1) == mask.end()) continue;
      Particles part = particles;
      keep(part, mask);
      add(std::move(part), completed(source.shows[show].look, source.look), show, places_in(mask));
    }
  }
  particles = {};
  particles.facts = std::move(facts);
  particles.cell = cell;
  return parts;
}

}  // namespace parray::input
