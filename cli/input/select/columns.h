#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cli/input/particles/particles.h"

/// Names of the columns of particles in selections, colour options and messages.
namespace parray::input {

/// Returns the column for one of the words "type", "name", "resname" and "chain". It is empty if
/// the file lacks it.
const NameColumn& name_column(std::string_view word, const Particles& particles);

/// Returns the plural of a word that name_column() knows: "chains" for "chain".
std::string plural_of(std::string_view word);

/// Returns "particle" if `count` is 1, otherwise "particles".
inline std::string particles_word(std::uint64_t count) {
  return in_number(count, "particle", "particles");
}

/// Returns the columns and numbers that the particles have: "elements, types, x, y, z, fx, fy, fz,
/// index".
std::string columns_of(const Particles& particles);

/// Returns whether a number's name means a numeric column of the file, which the reader loads only
/// on request. This is so for all names except those that the comment on number_source() lists.
bool is_number_column(std::string_view name);

/// Returns whether readers load a numeric column of this name, if the file has one. Readers load
/// the columns of is_number_column(). They also load fx, fy, fz and index, only for a note that
/// such a column is not used.
bool is_requested_column(std::string_view name);

/// A number that each particle has: writes the numbers of `out.size()` particles from `begin` on.
/// NaN: not known.
using NumberSource = std::function<void(std::size_t begin, std::span<double> out)>;

/// Returns the number `name`, which is a numeric column of the file or one of: x, y, z, radius,
/// index, resid (the residue's number), fx, fy, fz. `index` is Particles::index_of(), so hidden
/// particles count. fx, fy and fz are fractions of the cell along its edges a, b, c: 0 to 1 inside.
/// Without a cell, or with a flat one, they are fractions of the box around all centres. Returns an
/// empty function if these particles have no such number. They must outlive the result.
NumberSource number_source(std::string_view name, const Particles& particles);

/// Returns whether a number is a length in the file's unit: a position or a radius.
bool is_length_number(std::string_view name);

/// Returns the unit of a number; empty: unknown. Positions and radii have the file's unit of
/// length.
std::string unit_of(std::string_view name, const Particles& particles);

/// Returns the names that number_source() accepts for these particles.
std::vector<std::string> number_names(const Particles& particles);

}  // namespace parray::input
