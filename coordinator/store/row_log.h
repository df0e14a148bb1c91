#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "coordinator/store/store.h"

/// The form of a rows file, a job's log of results. It is a sequence of entries. append_rows() of
/// Store appends one entry. Each entry is
///
///     8 bytes  length of the data, little-endian
///     8 bytes  XXH3-64 of the data, little-endian
///     data
namespace parray::store {

/// Entries that are not in the file yet.
class PendingRows {
 public:
  /// Appends an entry. Move it into the call, because it may be large.
  void append(std::string entry);
  /// Calls `visit` with each entry, oldest first.
  void each(const Store::RowsVisitor& visit) const;

  /// Returns the pieces to write to the file, in order. They are valid until the next append().
  [[nodiscard]] std::vector<std::string_view> pieces() const;
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }  ///< size in the file

 private:
  struct Entry {
    std::string header;
    std::string data;
  };
  std::vector<Entry> entries_;
  std::uint64_t bytes_ = 0;
};

/// Calls `visit` with each entry in the first `bytes` bytes of the file. Needs memory for the
/// largest entry. Throws RunError that names the file if it is shorter or an entry is damaged,
/// after it has visited the entries before.
void each_entry_in(const std::filesystem::path& file, std::uint64_t bytes,
                   const Store::RowsVisitor& visit);

/// Returns whether the first `bytes` bytes of the file are complete entries. Returns true for 0
/// bytes, and false for an unreadable file. Reads headers only, so it checks no checksum.
bool ends_an_entry(const std::filesystem::path& file, std::uint64_t bytes);

/// Returns the size in bytes of the first `entries` entries; of all complete ones if there are
/// fewer; 0 for an unreadable file. Reads headers only.
std::uint64_t bytes_of_entries(const std::filesystem::path& file, std::uint64_t entries);

/// Returns the size in bytes of the entries before the first damaged or incomplete one. Returns 0
/// for an unreadable file. Reads the whole file and checks the checksums.
std::uint64_t sound_bytes(const std::filesystem::path& file);

}  // namespace parray::store
