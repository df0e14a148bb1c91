#pragma once

#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cli/input/particles/file_place.h"
#include "cli/input/particles/particles.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/expression.h"
#include "common/base/error.h"

namespace parray::input {

/// Error: a selection, colours, radii or arrows ask for a number that the particles do not have.
class UnknownNumber : public InputError {
 public:
  /// `place` precedes the message, such as "character 5: ". It may be empty.
  explicit UnknownNumber(std::string name, const std::string& place = {});
  /// Returns the message with a remedy. `known` are the names that would be valid.
  [[nodiscard]] std::string with_remedy(const std::vector<std::string>& known) const;

 private:
  std::string name_;
};

/// Returns number_source() (columns.h). If the particles lack the number, throws UnknownNumber for
/// a numeric column, otherwise SourceError with `key`.
NumberSource known_number(const char* key, const std::string& name, const Particles& particles);

/// Runs `work` and returns its result. Turns InputErrors other than UnknownNumber into SourceErrors
/// with `key`.
auto blaming(const char* key, const auto& work) {
  try {
    return work();
  } catch (const UnknownNumber&) {
    throw;
  } catch (const InputError& error) {
    throw SourceError(key, error.what());
  }
}

/// Selects particles of a file: "chain A and not water". scenes/README.md describes the language.
class Selection {
 public:
  /// Throws InputError "character N: problem: remedy"; N counts characters from 1.
  explicit Selection(std::string_view text);
  /// Selects particles of any of these classes: "water", "hydrogens". An empty list selects none.
  /// Throws InputError for an unknown word and suggests the nearest known one.
  static Selection any_of(const std::vector<std::string>& classes);

  /// Returns the names of the file's numeric columns that the selection needs.
  [[nodiscard]] std::set<std::string, std::less<>> numbers() const;

  /// Returns the selected particles. The result is the same for any number of threads. Takes linear
  /// time. `within` also sorts the particles from which it measures.
  ///
  /// Throws UnknownNumber if the particles lack a numeric column. Throws InputError "character N:
  /// problem: remedy" if they lack another column that the selection uses. The message of a
  /// selection from any_of() names no character.
  [[nodiscard]] ParticleMask mask(const Particles& particles, int threads = 1) const;

  /// Returns mask(). If that selects no particle, throws InputError: `problem`, then
  /// what_there_is() or, if that is empty, `otherwise`.
  [[nodiscard]] ParticleMask some(const Particles& particles, int threads,
                                  const std::string& problem, const char* otherwise) const;

  /// Describes the values that the particles have in the columns that the selection uses: "there
  /// are chains A, B; z from 0 to 31.5". Returns "" if the selection uses none. Helps a user whose
  /// selection is empty.
  [[nodiscard]] std::string what_there_is(const Particles& particles) const;

 private:
  explicit Selection(Expression root) : root_(std::move(root)) {}

  Expression root_;
};

/// Returns a mask with 1 for each particle of a class of molecules: "water", "protein", "nucleic",
/// "ion" or "virtual" (virtual sites). residues.h defines them by residue and atom names. The mask
/// has size 0 if no particle belongs to the class.
ParticleMask class_mask(std::string_view word, const Particles& particles);

/// Translates a slice such as "z=10:20" or "x=40%:60%,z=:5" into the text of a selection. The slice
/// includes its bounds. Either bound may be missing. Numbers are coordinates. Percentages are
/// fractions of the cell (fx, fy, fz in columns.h).
///
/// Throws InputError "problem: remedy".
std::string slice_as_selection(std::string_view text);

}  // namespace parray::input
