#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particle_mask.h"
#include "cli/input/particles/particles.h"
#include "cli/input/select/expression.h"
#include "common/base/error.h"

namespace parray::input {

/// A number that the particles do not have is asked for.
class UnknownNumber : public InputError {
 public:
  /// `place`: of its name, in front of the message, as "column 5: "; it may be empty.
  explicit UnknownNumber(std::string name, const std::string& place = {});
  /// `known`: the names that would have done.
  [[nodiscard]] std::string with_remedy(const std::vector<std::string>& known) const;

 private:
  std::string name_;
};

/// Which particles of a file are meant: "chain A and not water". scenes/README.md has the language.
class Selection {
 public:
  /// Throws InputError "column N: problem: remedy"; N counts characters from 1.
  explicit Selection(std::string_view text);
  /// Any of these classes of particles: "water", "hydrogens". Throws InputError that names the
  /// word that is none, with the nearest known one.
  static Selection any_of(const std::vector<std::string>& classes);

  /// The numeric columns that a reader must be asked for.
  [[nodiscard]] const std::set<std::string, std::less<>>& numbers() const { return numbers_; }

  /// Which of the particles are selected; the same for any number of threads. In time proportional
  /// to their number but for `within`, which sorts those that it is measured from.
  ///
  /// Throws UnknownNumber, and InputError "column N: problem: remedy" where the particles lack a
  /// column that the selection asks about.
  [[nodiscard]] ParticleMask mask(const Particles& particles, int threads = 1) const;

  /// What these particles have of what the selection asks about, for one that selects nothing:
  /// "there are chains A, B; z from 0 to 31.5". Columns that they lack are not spoken of.
  [[nodiscard]] std::string what_there_is(const Particles& particles) const;

 private:
  explicit Selection(Expression root);

  Expression root_;
  std::set<std::string, std::less<>> numbers_;
};

/// "z=10:20", "x=40%:60%,z=:5" as a selection: between the two numbers, each included, or between
/// fractions of the cell (see number_source.h); either may be left out.
///
/// Throws InputError "problem: remedy".
std::string slice_as_selection(std::string_view text);

}  // namespace parray::input
