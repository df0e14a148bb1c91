#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"
#include "cli/input/scene_file/json_fields.h"

namespace parray::input {

/// What of a file's particles is shown; by default all but virtual sites.
struct ParticleFilter {
  std::string select;                              ///< as in selection.h; empty: all
  std::string slice;                               ///< as in slice_as_selection(); empty: all
  std::optional<std::vector<std::string>> hide{};  ///< selection_classes(); not given: "virtual"

  friend bool operator==(const ParticleFilter&, const ParticleFilter&) = default;
};

/// The texts of the filter's members. Throw InputError, without a place, for what is none.
std::string select_from(const std::string& text);
std::string slice_from(const std::string& text);
/// Words with commas between, which are hidden beside virtual sites; "none": nothing is hidden.
std::vector<std::string> hide_from(std::string_view text);

/// From the keys select, slice and hide of an item of a scene's `particles`. Throws InputError with
/// the place.
ParticleFilter read_particle_filter(const JsonFields& fields);

/// The numeric columns that a reader must be asked for.
std::set<std::string, std::less<>> numbers_of(const ParticleFilter& filter);

/// Leaves out what the filter does not show, and notes how many under "hidden_CLASS" and
/// "not_selected". The same for any number of threads.
///
/// Throws UnknownNumber, and SourceError where the particles lack a column or none is left.
void apply(const ParticleFilter& filter, Particles& particles, int threads = 1);

}  // namespace parray::input
