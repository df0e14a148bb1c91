#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/store/store.h"

/// The form of a rows file: entries one after the other, each
///
///     8 bytes  length of the data, little-endian
///     8 bytes  XXH3-64 of the data, little-endian
///     data
namespace parray::store {

/// Entries that are not in the file yet. What is put in is moved, not copied: it may be large.
class FreshRows {
 public:
  void append(std::string entry);
  /// Visits the entries.
  void each(const Store::RowsVisitor& visit) const;

  /// What is to be written, one piece after the other; good until the next append().
  [[nodiscard]] std::vector<std::string_view> pieces() const;
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  struct Entry {
    std::string header;
    std::string data;
  };
  std::vector<Entry> entries_;
  std::uint64_t bytes_ = 0;
};

/// Visits the entries in the first `bytes` bytes of the file. No more memory than the largest
/// entry's. Throws RunError that names the file when it is shorter or an entry is damaged; the
/// entries before have been visited then.
void each_entry_in(const std::filesystem::path& file, std::uint64_t bytes,
                   const Store::RowsVisitor& visit);

/// Whether the first `bytes` bytes of the file are whole entries, as the headers say. Reads no
/// data.
bool ends_an_entry(const std::filesystem::path& file, std::uint64_t bytes);

/// Bytes of the first so many entries of the file, as the headers say; of all whole ones if there
/// are fewer.
std::uint64_t bytes_of_entries(const std::filesystem::path& file, std::uint64_t entries);

/// Bytes of the whole, undamaged entries at the beginning of the file; 0 if it cannot be read.
std::uint64_t sound_bytes(const std::filesystem::path& file);

}  // namespace parray::store
