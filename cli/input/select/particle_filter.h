#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

namespace parray::input {

/// Says which particles of a file are shown. The default shows all except virtual sites.
struct ParticleFilter {
  std::string select;                              ///< as in selection.h; empty: all
  std::string slice;                               ///< as in slice_as_selection(); empty: all
  std::optional<std::vector<std::string>> hide{};  ///< selection_classes(); not given: "virtual"

  friend bool operator==(const ParticleFilter&, const ParticleFilter&) = default;
};

/// Check the texts of the filter's members. Throw InputError, without a place, for invalid texts.
std::string select_from(const std::string& text);
std::string slice_from(const std::string& text);
/// Returns the words of a list with commas, and "virtual". "none" hides nothing.
std::vector<std::string> hide_from(std::string_view text);
/// Throws InputError if one of the words is none of selection_classes().
void check_hidden(const std::vector<std::string>& words);

/// Returns the numeric columns that the request must name.
std::set<std::string, std::less<>> numbers_of(const ParticleFilter& filter);

/// Removes the particles that the filter does not show. Notes count them under "hidden_CLASS" and
/// "not_selected". The result is the same for any number of threads.
///
/// Throws UnknownNumber, and SourceError if the particles lack a column or none is left.
void apply(const ParticleFilter& filter, Particles& particles, int threads = 1);

}  // namespace parray::input
