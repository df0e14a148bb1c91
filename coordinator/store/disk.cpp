#include "coordinator/store/disk.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <utility>

namespace parray::store {
namespace {

/// Computes a WholeFile from bytes that arrive in parts.
class Measuring {
 public:
  Measuring() { XXH3_64bits_reset(hash_.get()); }
  void add(std::string_view bytes) {
    bytes_ += bytes.size();
    XXH3_64bits_update(hash_.get(), bytes.data(), bytes.size());
  }
  [[nodiscard]] WholeFile result() const { return {bytes_, XXH3_64bits_digest(hash_.get())}; }

 private:
  std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash_{XXH3_createState(),
                                                                 &XXH3_freeState};
  std::uint64_t bytes_ = 0;
};

}  // namespace

ssize_t Disk::write(int file, std::string_view bytes, std::uint64_t offset) {
  return pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(offset));
}

int Disk::sync(int file) { return fdatasync(file); }
int Disk::sync_directory(int directory) { return fsync(directory); }
int Disk::sync_file_system(int directory) { return syncfs(directory); }
int Disk::rename(const char* from, const char* onto) { return std::rename(from, onto); }

Disk& system_disk() {
  static Disk disk;
  return disk;
}

OpenPath::OpenPath(const std::filesystem::path& path, int flags)
    : fd_(open(path.c_str(), flags | O_CLOEXEC | O_NONBLOCK, 0666)) {
  struct stat status {};
  const bool sound =
      fd_ >= 0 && fstat(fd_, &status) == 0 && (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode));
  if (fd_ >= 0 && !sound) {
    close(std::exchange(fd_, -1));
    errno = EINVAL;
  }
}

OpenPath::~OpenPath() {
  if (fd_ >= 0) close(fd_);
}

ssize_t OpenPath::read(std::span<char> bytes, std::uint64_t offset) const {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t got =
        pread(fd_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
    if (got < 0) return -1;
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return static_cast<ssize_t>(done);
}

std::optional<std::string> text_of_file(const std::filesystem::path& file) {
  const OpenPath in(file, O_RDONLY);
  std::error_code error;
  const std::uint64_t size = std::filesystem::file_size(file, error);
  if (in.get() < 0 || error) return std::nullopt;
  std::string bytes(size, '\0');
  return in.read(bytes, 0) == std::ssize(bytes) ? std::optional(std::move(bytes)) : std::nullopt;
}

WholeFile whole_file_of(std::span<const std::string_view> pieces) {
  Measuring file;
  for (const std::string_view piece : pieces) file.add(piece);
  return file.result();
}

std::optional<WholeFile> measure(const std::filesystem::path& file) {
  const OpenPath in(file, O_RDONLY);
  Measuring found;
  std::string block(std::size_t{1} << 20, '\0');
  for (std::uint64_t at = 0;; at += block.size()) {
    const ssize_t got = in.read(block, at);
    if (got < 0) return std::nullopt;
    found.add({block.data(), static_cast<std::size_t>(got)});
    if (got < std::ssize(block)) return found.result();
  }
}

}  // namespace parray::store
