#include "coordinator/store/row_log.h"

#include <fcntl.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "common/base/bytes.h"
#include "common/base/checksum.h"
#include "coordinator/store/disk.h"

namespace parray::store {

static constexpr std::uint64_t header_bytes = 16;

void PendingRows::append(std::string entry) {
  ByteWriter header;
  header.numbers(std::uint64_t{entry.size()}, checksum_of(entry));
  bytes_ += header_bytes + entry.size();
  entries_.push_back({header.take(), std::move(entry)});
}

void PendingRows::each(const Store::RowsVisitor& visit) const {
  for (const Entry& entry : entries_) visit(entry.data);
}

std::vector<std::string_view> PendingRows::pieces() const {
  std::vector<std::string_view> pieces;
  pieces.reserve(2 * entries_.size());
  for (const Entry& entry : entries_) {
    pieces.emplace_back(entry.header);
    pieces.emplace_back(entry.data);
  }
  return pieces;
}

void each_entry_in(const std::filesystem::path& file, std::uint64_t bytes,
                   const Store::RowsVisitor& visit) {
  if (bytes == 0) return;
  const auto damaged = [&](const std::string& why) {
    return RunError("the results in " + file.string() + " are damaged: " + why);
  };
  const OpenPath in(file, O_RDONLY);
  if (in.get() < 0) throw damaged(std::generic_category().message(errno));
  std::error_code error;
  if (std::filesystem::file_size(file, error) < bytes || error) {
    throw damaged("the file is shorter than its committed part");
  }
  std::uint64_t at = 0;
  std::string buffer;
  const auto read = [&](std::uint64_t size) -> std::string_view {
    if (size > bytes - at) {  // check before allocating memory
      throw damaged("an entry extends beyond the committed part");
    }
    buffer.resize(size);
    const ssize_t got = in.read(buffer, at);
    if (got < 0) throw damaged(std::generic_category().message(errno));
    if (got < std::ssize(buffer)) throw damaged("the file ends early");
    at += size;
    return buffer;
  };
  while (at < bytes) {
    ByteReader header(read(header_bytes));
    const auto length = header.get<std::uint64_t>();
    const auto checksum = header.get<std::uint64_t>();
    const std::string_view entry = read(length);
    if (checksum_of(entry) != checksum) throw damaged("an entry fails its checksum");
    visit(entry);
  }
}

/// Calls `visit` with the end of each entry in bytes until it returns false. Reads headers only.
static void each_end(const std::filesystem::path& file, const auto& visit) {
  const OpenPath in(file, O_RDONLY);
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  std::string header(header_bytes, '\0');
  for (std::uint64_t at = 0; !error && at + header_bytes <= size;) {
    if (in.read(header, at) != std::ssize(header)) return;
    const auto length = ByteReader(header).get<std::uint64_t>();
    if (length > size - at - header_bytes) return;
    at += header_bytes + length;
    if (!visit(at)) return;
  }
}

bool ends_an_entry(const std::filesystem::path& file, std::uint64_t bytes) {
  std::uint64_t last = 0;
  each_end(file, [&](std::uint64_t end) {
    last = end <= bytes ? end : last;
    return end < bytes;
  });
  return last == bytes;
}

std::uint64_t bytes_of_entries(const std::filesystem::path& file, std::uint64_t entries) {
  std::uint64_t last = 0;
  if (entries > 0) {
    each_end(file, [&](std::uint64_t end) {
      last = end;
      return --entries > 0;
    });
  }
  return last;
}

std::uint64_t sound_bytes(const std::filesystem::path& file) {
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  std::uint64_t sound = 0;
  try {
    each_entry_in(file, error ? 0 : size,
                  [&](std::string_view entry) { sound += header_bytes + entry.size(); });
  } catch (const RunError&) {
    return sound;
  }
  return sound;
}

}  // namespace parray::store
