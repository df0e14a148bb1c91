#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cli/input/select/expression.h"
#include "cli/input/select/number_source.h"
#include "cli/input/select/particle_classes.h"
#include "cli/input/select/selection.h"

namespace parray::input {

/// An expression with the columns of particles that it asks about. Refers to both.
class Condition {
 public:
  /// Throws as Selection::mask() does.
  Condition(const Expression& expression, const Particles& particles, int threads);

  /// For all particles.
  [[nodiscard]] ParticleMask mask() const;

 private:
  /// Particles that are looked at together.
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
  const std::vector<std::uint32_t>* index_ = nullptr;  ///< into the table; none: elements
  std::vector<std::uint8_t> table_;                    ///< 1 for what the condition holds for
  ParticleMask mask_;                                  ///< of all particles, where it is known
};

}  // namespace parray::input
