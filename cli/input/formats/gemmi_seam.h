#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/rooms.h"

/// The interface to gemmi, a library that reads CIF. Only gemmi_seam.cpp includes gemmi. That file
/// is compiled as C++17, because Clang rejects gemmi's headers in C++20.
namespace parray::input {

/// Returns the operations of a space group, each as a SymmetryOperation (crystal.h). `name` is the
/// number of the group, its Hermann-Mauguin symbol (short or long) or its Hall symbol. Returns an
/// empty list for other texts.
std::vector<std::array<double, 12>> operations_of_space_group(const std::string& name);

/// Receives the content of a CIF file in order. Outside of loops, each tag is followed by its
/// value. `text` includes its quotes. `line`: where it begins, from 1.
class CifVisitor {
 public:
  virtual ~CifVisitor() = default;
  virtual void start_block() = 0;
  virtual void start_loop() = 0;
  virtual void tag(std::string_view text, std::size_t line) = 0;
  virtual void value(std::string_view text, std::size_t line) = 0;
  virtual void end_loop() = 0;
};

/// Error: the text is not CIF from this line on.
class CifError : public std::runtime_error {
 public:
  CifError(const std::string& what, std::size_t line) : std::runtime_error(what), line_(line) {}
  [[nodiscard]] std::size_t line() const { return line_; }

 private:
  std::size_t line_;
};

/// Largest size of a value, a tag or a series of comments, in bytes.
inline constexpr std::size_t max_cif_text_bytes = std::size_t{1} << 22;

/// Parses CIF with gemmi's grammar. `read(to, bytes)` returns the number of the next bytes of the
/// file, and 0 at the end. Keeps one buffer of the file in memory. Throws CifError for invalid
/// text, and for a text or a series of comments above max_cif_text_bytes. Passes on the exceptions
/// of `read` and `visitor`.
void parse_cif(const std::function<std::size_t(char*, std::size_t)>& read, CifVisitor& visitor);

/// Returns a value without its quotes. Returns "" for '.' and '?'.
std::string cif_text(const std::string& value);

}  // namespace parray::input
