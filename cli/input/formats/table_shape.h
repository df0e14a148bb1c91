#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "cli/input/formats/table_names.h"
#include "cli/input/particles/packed_file.h"

/// Recognises the shape of text tables by their first lines.
namespace parray::input {

/// The shape of a text table.
struct TableShape {
  enum class Names : std::uint8_t {
    header,   ///< the first row has the names
    comment,  ///< a comment before the first row has the names
    none      ///< the rows are numbers without names
  };
  Names names = Names::header;
  char separator = ' ';     ///< between fields of the rows; see FieldSplitter
  bool certain = false;     ///< the first rows have this shape, or the header names positions
  bool counted = false;     ///< a row with the number of particles precedes the others
  bool numbered = false;    ///< the first row has the numbers of the columns: 0, 1, 2 (pandas)
  std::size_t first = 0;    ///< rows of numbers: the first column that is not an index, from 0
  std::size_t columns = 0;  ///< rows of numbers: number of columns from `first` on, >= 3
  TableNames comment{};     ///< the names in a comment
  std::uint64_t line = 0;   ///< line of that comment, from 1
  /// Units of columns by name, from a comment of astropy's ECSV.
  std::vector<std::pair<std::string, std::string>> units{};
};

/// Returns the shape of the table. If the file is no table, `certain` is false.
TableShape table_shape(const FileStart& start);

/// Returns whether the file is a table of numbers after a line with the number of rows (.pts).
/// Returns false for XYZ files: their second line is a comment.
bool is_counted_table(const FileStart& start);

}  // namespace parray::input
