#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cli/input/color/particle_colors.h"
#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/particle_source.h"

namespace parray::input {

/// Particles of a file that have one look.
struct ParticlePart {
  Particles particles;  ///< facts contain only the unit of length and notes on this part
  ParticleLook look;    ///< complete: see completed()
  /// Number of the representation, from 0. Nothing: the source has no representations.
  std::optional<std::size_t> representation{};
  /// For each particle of the part, its index in the particles that split() received. Empty: the
  /// part has all of them.
  std::vector<std::uint32_t> numbers{};
  // Set by parts_of():
  ParticleColors colors{};  ///< empty if its look has no `color_by`
  NumberBounds sized{};     ///< numbers with the least and the largest radius, of `radius_by`
};

/// Splits `particles` by the representations of `source`, in their order. A particle in several
/// selections belongs to the last one. Parts without particles are left out. Leaves the facts and
/// the cell in `particles`, and adds notes there: "shown_twice" counts particles in several
/// selections, "not_shown" those in none. The result is the same for any number of threads.
///
/// Throws UnknownNumber (selection.h) if a selection needs a numeric column that the particles
/// lack. Throws SourceError with the key "select" and the representation for a selection that needs
/// another missing column or that selects no particle.
std::vector<ParticlePart> split(Particles& particles, const ParticleSource& source,
                                int threads = 1);

/// Runs `work`. Adds the number of the representation to each SourceError.
void in_representation(const std::optional<std::size_t>& number, const auto& work) {
  try {
    work();
  } catch (const SourceError& error) {
    throw SourceError(error.key(), error.what(), number);
  }
}

}  // namespace parray::input
