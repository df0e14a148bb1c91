#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Which particles of a file are shown: those in `select` and `slice` that no class of `hide`
/// contains. By default, all particles except virtual sites are shown.
struct ParticleFilter {
  std::string select;  ///< a selection (selection.h); empty: all particles
  std::string slice;   ///< a slice (slice_as_selection() in selection.h); empty: all particles
  /// Words of selection_classes() in expression.h. Empty list: no class. Not given: "virtual".
  std::optional<std::vector<std::string>> hide{};

  friend bool operator==(const ParticleFilter&, const ParticleFilter&) = default;
};

/// Check the texts of the filter's members and return them. Throw InputError for invalid texts. The
/// message names neither a file nor an option.
std::string select_from(std::string_view text);
std::string slice_from(std::string_view text);
/// Returns "virtual" and the words of a list with commas, in lower case. Returns an empty list for
/// "none", in any letter case.
std::vector<std::string> hide_from(std::string_view text);
/// Throws InputError if a word is not in selection_classes().
void check_hidden(const std::vector<std::string>& words);

/// Removes the particles that the filter does not show. Notes count them as "hidden_CLASS",
/// "not_in_slice" and "not_in_select", each particle once, under the first that applies. The class
/// "virtual" has no effect if it contains all particles. The result is the same for any number of
/// threads.
///
/// Throws UnknownNumber (selection.h) if the particles lack a numeric column. Throws SourceError
/// with the key "hide", "slice" or "select" if that text is not valid, if the particles lack
/// another column, or if none remains.
void apply(const ParticleFilter& filter, Particles& particles, int threads = 1);

}  // namespace parray::input
