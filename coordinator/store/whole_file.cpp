#include "coordinator/store/whole_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cerrno>
#include <memory>
#include <string>
#include <utility>

namespace parray::store {

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

WholeFile whole_file_of(std::span<const std::string_view> pieces) {
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash(XXH3_createState(),
                                                                      &XXH3_freeState);
  XXH3_64bits_reset(hash.get());
  WholeFile made;
  for (const std::string_view piece : pieces) {
    made.bytes += piece.size();
    XXH3_64bits_update(hash.get(), piece.data(), piece.size());
  }
  made.checksum = XXH3_64bits_digest(hash.get());
  return made;
}

std::optional<WholeFile> measure(const std::filesystem::path& file) {
  const OpenPath in(file, O_RDONLY);
  const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash(XXH3_createState(),
                                                                      &XXH3_freeState);
  XXH3_64bits_reset(hash.get());
  WholeFile found;
  std::string block(std::size_t{1} << 20, '\0');
  for (;;) {
    const ssize_t got = in.get() < 0 ? -1 : ::read(in.get(), block.data(), block.size());
    if (got < 0) return std::nullopt;
    if (got == 0) {
      found.checksum = XXH3_64bits_digest(hash.get());
      return found;
    }
    XXH3_64bits_update(hash.get(), block.data(), static_cast<std::size_t>(got));
    found.bytes += static_cast<std::uint64_t>(got);
  }
}

}  // namespace parray::store
