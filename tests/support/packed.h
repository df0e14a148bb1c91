#pragma once

#include <archive.h>
#include <archive_entry.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "tests/support/rooms.h"

namespace parray::test {

/// Returns `bytes` compressed by gzip, bzip2, xz or zstd.
inline std::string packed(const std::string& bytes, const std::string& packing = "gzip") {
  struct Free {
    void operator()(archive* opened) const { archive_write_free(opened); }
    void operator()(archive_entry* entry) const { archive_entry_free(entry); }
  };
  const std::unique_ptr<archive, Free> writer(archive_write_new());
  const std::unique_ptr<archive_entry, Free> entry(archive_entry_new());
  std::string out(bytes.size() + bytes.size() / 8 + 4096, '\0');
  std::size_t used = 0;
  archive_entry_set_pathname(entry.get(), "data");
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_write_set_bytes_in_last_block(writer.get(), 1);
  const bool good =
      archive_write_set_format_raw(writer.get()) == ARCHIVE_OK &&
      archive_write_add_filter_by_name(writer.get(), packing.c_str()) == ARCHIVE_OK &&
      archive_write_open_memory(writer.get(), out.data(), out.size(), &used) == ARCHIVE_OK &&
      archive_write_header(writer.get(), entry.get()) == ARCHIVE_OK &&
      archive_write_data(writer.get(), bytes.data(), bytes.size()) >= 0 &&
      archive_write_close(writer.get()) == ARCHIVE_OK;
  if (!good) throw std::runtime_error("packing by " + packing + " failed");
  out.resize(used);
  return out;
}

}  // namespace parray::test
