#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Which particles of a file are shown. By default, all particles except virtual sites are shown.
struct ParticleFilter {
  std::string select;  ///< a selection (selection.h); empty: all particles
  std::string slice;   ///< a slice (slice_as_selection()); empty: all particles
  std::optional<std::vector<std::string>>
      hide{};  ///< words of selection_classes(); not given: "virtual"

  friend bool operator==(const ParticleFilter&, const ParticleFilter&) = default;
};

/// Check the texts of the filter's members and return them. Throw InputError, which names no place,
/// for invalid texts.
std::string select_from(std::string_view text);
std::string slice_from(std::string_view text);
/// Returns the words of a list with commas, and "virtual". Returns nothing for "none".
std::vector<std::string> hide_from(std::string_view text);
/// Throws InputError if a word is not in selection_classes().
void check_hidden(const std::vector<std::string>& words);

/// Returns the numeric columns of the file that the filter needs.
std::set<std::string, std::less<>> numbers_of(const ParticleFilter& filter);

/// Removes the particles that the filter hides. Notes count them as "hidden_CLASS", "not_in_slice"
/// and "not_in_select". The result is the same for any number of threads.
///
/// Throws UnknownNumber. Throws SourceError if the particles lack a column or if no particle
/// remains.
void apply(const ParticleFilter& filter, Particles& particles, int threads = 1);

}  // namespace parray::input
