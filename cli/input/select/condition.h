#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cli/input/particles/particles.h"
#include "cli/input/select/columns.h"
#include "cli/input/select/expression.h"
#include "cli/input/select/selection.h"

namespace parray::input {

/// Classes of particles in molecules. residues.h defines them by residue and atom names.
enum class ParticleClass : std::uint8_t { water, protein, nucleic, ion, virtual_site };

/// Returns a mask with 1 for each particle of a class. The mask has size 0 if no particle belongs
/// to the class.
ParticleMask class_mask(ParticleClass wanted, const Particles& particles);

/// An expression that is bound to the columns of particles. The expression and the particles must
/// outlive this object.
class Condition {
 public:
  /// Throws the errors of Selection::mask() (selection.h).
  Condition(const Expression& expression, const Particles& particles, int threads);

  /// Returns a mask with 1 for each particle that satisfies the expression. The expression must be
  /// a condition, not a number.
  [[nodiscard]] ParticleMask mask() const;

 private:
  /// Number of particles that are evaluated together.
  static constexpr std::size_t block = 256;

  void take_table(const NameColumn& column, const std::vector<std::uint8_t>& table);
  void bind();
  void bind_number();
  void bind_names();
  void bind_class(ParticleClass wanted);
  void bind_elements();
  void bind_within();
  void bind_same_residue();
  [[noreturn]] void fail_without(const std::string& what) const;

  void holds(std::size_t begin, std::span<std::uint8_t> out) const;
  void compare(std::size_t begin, std::span<std::uint8_t> out) const;
  void numbers(std::size_t begin, std::span<double> out) const;
  [[nodiscard]] bool in_ranges(double number) const;

  const Expression* expression_;
  const Particles* particles_;
  int threads_;
  std::vector<Condition> parts_;
  std::optional<NumberSource> number_;
  const std::vector<std::uint32_t>* index_ =
      nullptr;  ///< column of indices into `table_`; null: the elements are the indices
  std::vector<std::uint8_t> table_;  ///< 1 for each entry that satisfies the condition
  ParticleMask mask_;  ///< of all particles; empty if the condition is evaluated in blocks
};

}  // namespace parray::input
