#include "coordinator/store/row_log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include "common/base/bytes.h"
#include "common/base/checksum.h"

namespace parray::store {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { static_cast<void>(std::fclose(file)); }
};

using FilePointer = std::unique_ptr<std::FILE, CloseFile>;

constexpr std::uint64_t header_bytes = 16;

/// Opens a file for reading. Returns null and sets errno if that fails. Never blocks: a pipe or
/// device is an error (EINVAL).
FilePointer open_file(const std::filesystem::path& path) {
  const int fd = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status {};
  if (fd >= 0 && (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode))) {
    close(fd);
    errno = EINVAL;
    return nullptr;
  }
  return FilePointer(fd < 0 ? nullptr : fdopen(fd, "rb"));
}

/// Reads the committed entries of a rows file in order.
class LogReader {
 public:
  LogReader(const std::filesystem::path& path, std::uint64_t bytes)
      : path_(path), remaining_(bytes), file_(open_file(path)) {
    if (!file_) damaged(std::generic_category().message(errno));
    std::error_code error;
    if (std::filesystem::file_size(path, error) < bytes || error) {
      damaged("the file is shorter than its committed part");
    }
  }

  [[nodiscard]] bool done() const { return remaining_ == 0; }

  std::string_view next() {
    ByteReader header(read(header_bytes));
    const auto length = header.get<std::uint64_t>();
    const auto checksum = header.get<std::uint64_t>();
    const std::string_view entry = read(length);
    if (checksum_of(entry) != checksum) damaged("an entry fails its checksum");
    return entry;
  }

 private:
  std::string_view read(std::uint64_t size) {
    if (size > remaining_) {  // check before allocating memory
      damaged("an entry extends beyond the committed part");
    }
    remaining_ -= size;
    buffer_.resize(size);
    if (std::fread(buffer_.data(), 1, size, file_.get()) != size) {
      damaged(std::generic_category().message(errno));
    }
    return buffer_;
  }

  [[noreturn]] void damaged(const std::string& why) const {
    throw RunError("the results in " + path_.string() + " are damaged: " + why);
  }

  std::filesystem::path path_;
  std::uint64_t remaining_;  ///< bytes
  FilePointer file_;
  std::string buffer_;
};

}  // namespace

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
  for (LogReader reader(file, bytes); !reader.done();) visit(reader.next());
}

/// Calls `visit` with the end of each entry in bytes until it returns false. Reads headers only.
static void each_end(const std::filesystem::path& file, const auto& visit) {
  const FilePointer in = open_file(file);
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  std::string header(header_bytes, '\0');
  for (std::uint64_t at = 0; in && !error && at + header_bytes <= size;) {
    if (std::fseek(in.get(), static_cast<long>(at), SEEK_SET) != 0 ||
        std::fread(header.data(), 1, header_bytes, in.get()) != header_bytes) {
      return;
    }
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
