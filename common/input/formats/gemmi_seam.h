#pragma once

#include <cstddef>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

/// The one place that touches gemmi. C++17, because gemmi's headers are: Clang refuses them as
/// C++20.
namespace parray {

/// What a record ATOM or HETATM of PDB says beside the position.
struct PdbAtom {
  std::string chain;
  std::string residue_number;  ///< with its insertion code
  std::string residue_name;
  std::string name;
  int atomic_number = 0;  ///< by its columns, or the name's where they are blank; 0: unknown
  bool alternative_location = false;  ///< one of several
  double occupancy = 1;
};

/// `record` without its line end. Throws std::runtime_error for what is no such record.
PdbAtom parse_pdb_atom(const std::string& record);

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

}  // namespace parray
