#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

/// The one place that touches gemmi. C++17, because gemmi's headers are: Clang refuses them as
/// C++20.
namespace parray::input {

/// The operations of a space group, as SymmetryOperation (symmetry_operation.h) has them: by its
/// number, or its symbol after Hermann and Mauguin or Hall, short or long, as gemmi knows them;
/// none for other texts.
std::vector<std::array<double, 12>> operations_of_space_group(const std::string& name);

/// What a CIF file holds, in its order. `text` is as it stands in the file, in its quotes.
class CifVisitor {
 public:
  virtual ~CifVisitor() = default;
  virtual void start_block() = 0;
  virtual void start_loop() = 0;
  virtual void tag(std::string_view text, std::size_t line) = 0;
  virtual void value(std::string_view text, std::size_t line) = 0;
  virtual void end_loop() = 0;
};

/// The text is no CIF from this line on.
class CifError : public std::runtime_error {
 public:
  CifError(const std::string& what, std::size_t line) : std::runtime_error(what), line_(line) {}
  [[nodiscard]] std::size_t line() const { return line_; }

 private:
  std::size_t line_;
};

inline constexpr std::size_t max_cif_text_bytes = std::size_t{1} << 22;

/// Parses CIF by gemmi's grammar. `read(to, bytes)` gives the next bytes of the file, and how many;
/// 0 at its end. Holds one buffer of it. Throws CifError, also for a text or a run of comments of
/// more than max_cif_text_bytes, and what `read` and `visitor` throw.
void parse_cif(const std::function<std::size_t(char*, std::size_t)>& read, CifVisitor& visitor);

/// A value without its quotes; empty for '.' and '?'.
std::string cif_text(const std::string& value);

}  // namespace parray::input
