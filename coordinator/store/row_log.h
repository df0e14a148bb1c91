#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "coordinator/store/store.h"

/// The form of a rows file: entries one after the other, each
///
///     8 bytes  length of the data, little-endian
///     8 bytes  XXH3-64 of the data, little-endian
///     data
namespace parray {

/// Appends an entry to `log`.
void append_entry(std::string& log, std::string_view entry);

/// Visits the entries of `log`, which append_entry() has made in this life.
void each_entry(std::string_view log, const Store::RowsVisitor& visit);

/// Visits the entries in the first `bytes` bytes of the file. No more memory than the largest
/// entry's. Throws RunError that names the file when it is shorter or an entry is damaged; the
/// entries before have been visited then.
void each_entry_in(const std::filesystem::path& file, std::uint64_t bytes,
                   const Store::RowsVisitor& visit);

}  // namespace parray
